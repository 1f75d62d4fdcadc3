#pragma once

#include <span>
#include <string_view>

/// Every table of a scene file and its keys, in the order of scenes/README.md. The loader refuses
/// all other keys. A test checks that the README describes exactly these.
namespace hpdm {

inline constexpr std::string_view kRootKeys[] = {
    "scene", "timing",     "organ", "contact",  "attachment",  "duct",
    "cut",   "instrument", "load",  "exercise", "laparoscope", "file"};
inline constexpr std::string_view kSceneKeys[] = {"name", "gravity", "background", "left_handed"};
inline constexpr std::string_view kTimingKeys[] = {"haptic_hz", "deformation_hz", "render_hz",
                                                   "patch_delay_ticks", "step_budget"};

inline constexpr std::string_view kOrganKeys[] = {
    "name",           "mesh",         "unit",   "model",    "texture", "pose",
    "motion",         "lattice",      "energy", "material", "region",  "support",
    "wall_stiffness", "subdivisions", "free",   "lumen",    "layer"};
inline constexpr std::string_view kContactKeys[] = {"a", "b", "friction"};
inline constexpr std::string_view kAttachmentKeys[] = {
    "name",   "label", "a",         "b",        "box",       "box_fraction", "sphere",     "path_a",
    "path_b", "young", "thickness", "strength", "toughness", "reach",        "burn_energy"};
inline constexpr std::string_view kDuctKeys[] = {"name",   "label", "a",     "b",     "path",
                                                 "radius", "wall",  "young", "colour"};
inline constexpr std::string_view kCutKeys[] = {"organ", "strip"};
inline constexpr std::string_view kPoseKeys[] = {"position", "rotation_deg"};
inline constexpr std::string_view kLatticeKeys[] = {"basis",
                                                    "degree",
                                                    "cells",
                                                    "margin",
                                                    "split",
                                                    "notch_functions",
                                                    "local_functions",
                                                    "local_refinement",
                                                    "adaptive_functions",
                                                    "adaptive_levels"};
inline constexpr std::string_view kMotionKeys[] = {"displacement", "frequency"};
inline constexpr std::string_view kEnergyKeys[] = {
    "type",          "strain",     "law", "solver", "domain", "alpha", "beta", "newton_iterations",
    "newton_budget", "finite_from"};
inline constexpr std::string_view kMaterialKeys[] = {"young", "poisson", "density", "prony",
                                                     "relaxation_time"};
inline constexpr std::string_view kPronyKeys[] = {"share", "time"};
inline constexpr std::string_view kRegionKeys[] = {"box", "box_fraction", "sphere", "young"};
inline constexpr std::string_view kSupportKeys[] = {"box",   "box_fraction", "sphere",
                                                    "fixed", "stiffness",    "viscoelastic"};
inline constexpr std::string_view kLumenKeys[] = {
    "box",          "box_fraction", "sphere",          "filled",
    "bulk_modulus", "pressure",     "leak_resistance", "perforated_at"};
inline constexpr std::string_view kLayerKeys[] = {"box",       "box_fraction", "sphere",
                                                  "stiffness", "poisson",      "strength"};
inline constexpr std::string_view kFreeKeys[] = {"drag"};
inline constexpr std::string_view kBoxKeys[] = {"min", "max"};
inline constexpr std::string_view kSphereKeys[] = {"centre", "radius"};

inline constexpr std::string_view kInstrumentKeys[] = {"name",
                                                       "type",
                                                       "trocar",
                                                       "mesh",
                                                       "jaws",
                                                       "insulated_from",
                                                       "tip_radius",
                                                       "shaft_radius",
                                                       "friction",
                                                       "trocar_friction",
                                                       "trocar_torque",
                                                       "reaction",
                                                       "k1",
                                                       "k2",
                                                       "device",
                                                       "hand",
                                                       "trace",
                                                       "exchange",
                                                       "closing_force",
                                                       "jaw_friction",
                                                       "power",
                                                       "clips"};
inline constexpr std::string_view kJawKeys[] = {"meshes", "pivot", "opening_deg"};
inline constexpr std::string_view kExchangeKeys[] = {
    "name",         "type",     "mesh",          "jaws",         "insulated_from", "tip_radius",
    "shaft_radius", "friction", "closing_force", "jaw_friction", "power",          "clips"};
inline constexpr std::string_view kDeviceKeys[] = {"profile",
                                                   "mass",
                                                   "rotational_inertia",
                                                   "damping",
                                                   "rotational_damping",
                                                   "friction",
                                                   "rotational_friction",
                                                   "encoder_step",
                                                   "angle_encoder_step",
                                                   "jaw_encoder_step",
                                                   "max_force",
                                                   "max_torque",
                                                   "max_force_rate",
                                                   "max_angle",
                                                   "min_insertion",
                                                   "max_insertion",
                                                   "delay",
                                                   "passivity_control"};
inline constexpr std::string_view kHandKeys[] = {"script",  "seed",   "organ", "target",
                                                 "depth",   "spread", "speed", "stiffness",
                                                 "damping", "tremor"};

inline constexpr std::string_view kTraceKeys[] = {"file", "scale", "rotation_deg", "position",
                                                  "speed"};

inline constexpr std::string_view kLoadKeys[] = {"organ", "point",        "radius",
                                                 "force", "displacement", "pressure",
                                                 "box",   "box_fraction", "sphere"};
inline constexpr std::string_view kExerciseKeys[] = {"name",    "goal", "time_limit", "target_time",
                                                     "removes", "stay", "step",       "error"};
inline constexpr std::string_view kExerciseStepKeys[] = {
    "name", "instruction", "hold", "hold_with", "lift",  "touch", "touch_with", "at",    "within",
    "free", "from",        "area", "clip",      "clips", "cut",   "release",    "force", "time"};
inline constexpr std::string_view kExerciseErrorKeys[] = {
    "kind", "name", "limit", "organ", "duct", "before", "path", "within", "points"};
inline constexpr std::string_view kLaparoscopeKeys[] = {
    "position", "target", "trocar", "angle_deg", "field_of_view_deg", "focal_length", "distortion"};

inline constexpr std::string_view kFileKeys[] = {"name", "copy", "sha256"};

struct SceneTable {
  std::string_view path;  ///< As in the file's headers: "organ.lattice"; empty for the root.
  std::span<const std::string_view> keys;
};

inline constexpr SceneTable kSceneTables[] = {
    {"", kRootKeys},
    {"scene", kSceneKeys},
    {"timing", kTimingKeys},
    {"organ", kOrganKeys},
    {"organ.pose", kPoseKeys},
    {"organ.motion", kMotionKeys},
    {"organ.lattice", kLatticeKeys},
    {"organ.energy", kEnergyKeys},
    {"organ.material", kMaterialKeys},
    {"organ.material.prony", kPronyKeys},
    {"organ.region", kRegionKeys},
    {"organ.region.box", kBoxKeys},
    {"organ.region.box_fraction", kBoxKeys},
    {"organ.region.sphere", kSphereKeys},
    {"organ.lumen", kLumenKeys},
    {"organ.lumen.box", kBoxKeys},
    {"organ.lumen.box_fraction", kBoxKeys},
    {"organ.lumen.sphere", kSphereKeys},
    {"organ.layer", kLayerKeys},
    {"organ.layer.box", kBoxKeys},
    {"organ.layer.box_fraction", kBoxKeys},
    {"organ.layer.sphere", kSphereKeys},
    {"organ.support", kSupportKeys},
    {"organ.support.box", kBoxKeys},
    {"organ.support.box_fraction", kBoxKeys},
    {"organ.support.sphere", kSphereKeys},
    {"organ.free", kFreeKeys},
    {"contact", kContactKeys},
    {"attachment", kAttachmentKeys},
    {"attachment.box", kBoxKeys},
    {"attachment.box_fraction", kBoxKeys},
    {"attachment.sphere", kSphereKeys},
    {"duct", kDuctKeys},
    {"cut", kCutKeys},
    {"instrument", kInstrumentKeys},
    {"instrument.jaws", kJawKeys},
    {"instrument.device", kDeviceKeys},
    {"instrument.hand", kHandKeys},
    {"instrument.trace", kTraceKeys},
    {"instrument.exchange", kExchangeKeys},
    {"instrument.exchange.jaws", kJawKeys},
    {"load", kLoadKeys},
    {"load.box", kBoxKeys},
    {"load.box_fraction", kBoxKeys},
    {"load.sphere", kSphereKeys},
    {"exercise", kExerciseKeys},
    {"exercise.step", kExerciseStepKeys},
    {"exercise.error", kExerciseErrorKeys},
    {"laparoscope", kLaparoscopeKeys},
    {"file", kFileKeys},
};

}  // namespace hpdm
