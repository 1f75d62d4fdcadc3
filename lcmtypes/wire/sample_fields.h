#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <tuple>

#include "engine/snapshots.h"
#include "hpdm/contact_t.hpp"
#include "hpdm/force_t.hpp"
#include "hpdm/tool_t.hpp"

/// The fields of a haptic tick and of a deformation step that a session logs. This is the only list
/// of them: the codec, a replay's comparison and the tests visit it. Constant; any thread.
namespace hpdm {

/// How a replay compares a field.
enum class FieldUse {
  kCompared,    ///< With the logged value; real numbers relative to the field's largest value.
  kRelative,    ///< With the logged value, which is a relative number already.
  kNotCompared  ///< Not at all: the place in the log, or measured by a clock.
};

/// Values that a decoder accepts.
struct FieldRange {
  double min = 0;
  double max = 0;
};

struct FieldInfo {
  const char* name;  ///< As in engine/snapshots.h.
  FieldUse use = FieldUse::kCompared;
  std::optional<FieldRange> range = std::nullopt;  ///< Absent: any value, NaN included.
};

/// A field: its place in the message and in the sample.
template <typename Message, typename Wire, typename Sample, typename Value>
struct Field : FieldInfo {
  constexpr Field(FieldInfo info, Wire Message::*in_message, Value Sample::*in_sample)
      : FieldInfo(info), message(in_message), sample(in_sample) {}
  Wire Message::*message;
  Value Sample::*sample;
};

namespace logged {

inline constexpr FieldUse kNotCompared = FieldUse::kNotCompared;
inline constexpr FieldRange kShare{0, 1};
inline constexpr FieldRange kInstrumentIndex{0, kMaxHeld - 1};
inline constexpr FieldRange kKind{0, static_cast<double>(ContactKind::kGrasp)};
inline constexpr FieldRange kReaction{0, static_cast<double>(ReactionType::kPaper)};
inline constexpr FieldRange kActionKind{0, static_cast<double>(DuctActionKind::kCut)};
inline constexpr FieldRange kDuctIndex{-1, kMaxDucts - 1};
inline constexpr FieldRange kCount{0, std::numeric_limits<std::int32_t>::max()};

// A haptic tick's input.
inline constexpr std::tuple kTickInput{
    Field({"tick", kNotCompared}, &tool_t::tick, &HapticSample::tick),
    Field({"time_ns", kNotCompared}, &tool_t::time_ns, &HapticSample::time_ns),
    Field({"device_time_ns"}, &tool_t::device_time_ns, &HapticSample::device_time_ns),
    Field({"wake_late_ns", kNotCompared}, &tool_t::wake_late_ns, &HapticSample::wake_late_ns),
    Field({"paused"}, &tool_t::paused, &HapticSample::paused)};
inline constexpr std::tuple kRestart{
    Field({.name = "restart.count", .range = kCount}, &tool_t::restarts, &RestartRequest::count),
    Field({"restart.step"}, &tool_t::restart_step, &RestartRequest::step)};
inline constexpr std::tuple kSkipped{
    Field({"skipped.late_wake_up", kNotCompared}, &tool_t::skipped_late_wake_up,
          &SkippedTicks::late_wake_up),
    Field({"skipped.long_compute", kNotCompared}, &tool_t::skipped_long_compute,
          &SkippedTicks::long_compute),
    Field({"skipped.stalled", kNotCompared}, &tool_t::skipped_stalled, &SkippedTicks::stalled)};
inline constexpr std::tuple kToolInput{
    Field({.name = "instrument_index", .range = kInstrumentIndex}, &tool_input_t::instrument_index,
          &ToolSample::instrument_index),
    Field({"joints"}, &tool_input_t::joints, &ToolSample::joints),
    Field({"p_tip_W"}, &tool_input_t::p_tip, &ToolSample::p_tip_W),
    Field({"v_tip_W"}, &tool_input_t::v_tip, &ToolSample::v_tip_W),
    Field({"device_time_ns"}, &tool_input_t::device_time_ns, &ToolSample::device_time_ns),
    Field({"device_valid"}, &tool_input_t::device_valid, &ToolSample::device_valid),
    Field({"force_on"}, &tool_input_t::force_on, &ToolSample::force_on),
    Field({"pedal"}, &tool_input_t::pedal, &ToolSample::pedal)};

// A haptic tick's output.
inline constexpr std::tuple kTickOutput{
    Field({"tick", kNotCompared}, &force_t::tick, &HapticSample::tick),
    Field({"time_ns", kNotCompared}, &force_t::time_ns, &HapticSample::time_ns),
    Field({"patch_number"}, &force_t::patch_number, &HapticSample::patch_number),
    Field({"patch_age_ns"}, &force_t::patch_age_ns, &HapticSample::patch_age_ns),
    Field({"written_ns", kNotCompared}, &force_t::written_ns, &HapticSample::written_ns),
    Field({"compute_ns", kNotCompared}, &force_t::compute_ns, &HapticSample::compute_ns)};
inline constexpr std::tuple kToolOutput{
    Field({"organ"}, &tool_force_t::organ, &ToolSample::organ),
    Field({.name = "kind", .range = kKind}, &tool_force_t::kind, &ToolSample::kind),
    Field({"depth"}, &tool_force_t::depth, &ToolSample::depth),
    Field({"slip"}, &tool_force_t::slip, &ToolSample::slip),
    Field({"reaction_W"}, &tool_force_t::reaction, &ToolSample::reaction_W),
    Field({"guard_flags"}, &tool_force_t::guard_flags, &ToolSample::guard_flags),
    Field({"energy"}, &tool_force_t::energy, &ToolSample::energy),
    Field({"damping"}, &tool_force_t::damping, &ToolSample::damping),
    Field({"force_W"}, &tool_force_t::force, &ToolSample::force_W),
    Field({"effort"}, &tool_force_t::effort, &ToolSample::effort)};

// A deformation step.
inline constexpr std::tuple kStep{
    Field({"number"}, &contact_t::step, &StepRecord::number),
    Field({"input_tick"}, &contact_t::input_tick, &StepRecord::input_tick),
    Field({"time_ns"}, &contact_t::time_ns, &StepRecord::time_ns),
    Field({"device_time_ns"}, &contact_t::device_time_ns, &StepRecord::device_time_ns),
    Field({"wake_late_ns", kNotCompared}, &contact_t::wake_late_ns, &StepRecord::wake_late_ns),
    Field({"compute_ns", kNotCompared}, &contact_t::compute_ns, &StepRecord::compute_ns),
    Field({"iterations"}, &contact_t::iterations, &StepRecord::iterations),
    Field({"flags"}, &contact_t::flags, &StepRecord::flags),
    Field({"shed_level"}, &contact_t::shed_level, &StepRecord::shed_level),
    Field({"kept_step"}, &contact_t::kept_step, &StepRecord::kept_step),
    Field({"restarted_step"}, &contact_t::restarted_step, &StepRecord::restarted_step)};
// Visited last: the residual of a converged iteration consists of rounding errors.
inline constexpr std::tuple kResidual{
    Field({"residual", FieldUse::kRelative}, &contact_t::residual, &StepRecord::residual)};
inline constexpr std::tuple kRelaxation{
    Field({.name = "organs.iterations", .range = kCount}, &organ_relaxation_t::iterations,
          &OrganRelaxation::iterations),
    Field({"organs.out_of_time"}, &organ_relaxation_t::out_of_time, &OrganRelaxation::out_of_time),
    Field({.name = "organs.finite_strain_blend", .range = kShare},
          &organ_relaxation_t::finite_strain_blend, &OrganRelaxation::finite_strain_blend),
    Field({.name = "organs.refinement_weight", .range = kShare},
          &organ_relaxation_t::refinement_weight, &OrganRelaxation::refinement_weight),
    Field({"organs.body_energy"}, &organ_relaxation_t::body_energy, &OrganRelaxation::body_energy)};
inline constexpr std::tuple kAttachment{
    Field({"attachments.load_W"}, &attachment_outcome_t::load, &AttachmentOutcome::load_W),
    Field({.name = "attachments.largest_damage", .range = kShare},
          &attachment_outcome_t::largest_damage, &AttachmentOutcome::largest_damage),
    Field({"attachments.freed_area"}, &attachment_outcome_t::freed_area,
          &AttachmentOutcome::freed_area),
    Field({"attachments.burnt_area"}, &attachment_outcome_t::burnt_area,
          &AttachmentOutcome::burnt_area),
    Field({"attachments.cut_area"}, &attachment_outcome_t::cut_area, &AttachmentOutcome::cut_area),
    Field({"attachments.dissipated"}, &attachment_outcome_t::dissipated,
          &AttachmentOutcome::dissipated)};
inline constexpr std::tuple kDuct{
    Field({"ducts.load_W"}, &duct_outcome_t::load, &DuctOutcome::load_W),
    Field({"ducts.tension"}, &duct_outcome_t::tension, &DuctOutcome::tension),
    Field({"ducts.length"}, &duct_outcome_t::length, &DuctOutcome::length),
    Field({.name = "ducts.clips", .range = kCount}, &duct_outcome_t::clips, &DuctOutcome::clips),
    Field({.name = "ducts.cuts", .range = kCount}, &duct_outcome_t::cuts, &DuctOutcome::cuts)};
// The tool's pose without X_WT, which is two fields of the message.
inline constexpr std::tuple kPose{
    Field({"p_trocar_W"}, &tool_contact_t::p_trocar, &ToolPose::p_trocar_W),
    Field({"v_tip_W"}, &tool_contact_t::v_tip, &ToolPose::v_tip_W),
    Field({"jaw"}, &tool_contact_t::jaw, &ToolPose::jaw),
    Field({.name = "instrument_index", .range = kInstrumentIndex},
          &tool_contact_t::instrument_index, &ToolPose::instrument_index),
    Field({"pedal"}, &tool_contact_t::pedal, &ToolPose::pedal)};
inline constexpr std::tuple kLayerWork{
    Field({"burning"}, &tool_contact_t::burning, &LayerWork::burning),
    Field({"cut_area"}, &tool_contact_t::cut_area, &LayerWork::cut_area)};
inline constexpr std::tuple kDuctAction{
    Field({.name = "duct_action", .range = kActionKind}, &tool_contact_t::duct_action,
          &DuctAction::kind),
    Field({.name = "duct", .range = kDuctIndex}, &tool_contact_t::duct, &DuctAction::duct),
    Field({"duct_arc"}, &tool_contact_t::duct_arc, &DuctAction::arc),
    Field({"duct_length"}, &tool_contact_t::duct_length, &DuctAction::length),
    Field({"duct_angle"}, &tool_contact_t::duct_angle, &DuctAction::angle),
    Field({.name = "duct_coverage", .range = kShare}, &tool_contact_t::duct_coverage,
          &DuctAction::coverage),
    Field({"duct_place_W"}, &tool_contact_t::p_duct, &DuctAction::place_W)};
inline constexpr std::tuple kNearDuct{
    Field({.name = "near_duct", .range = kDuctIndex}, &tool_contact_t::near_duct, &NearDuct::duct),
    Field({"near_duct_gap"}, &tool_contact_t::near_duct_gap, &NearDuct::gap)};
inline constexpr std::tuple kContact{
    Field({"organ"}, &tool_contact_t::organ, &SolvedContact::organ),
    Field({.name = "kind", .range = kKind}, &tool_contact_t::kind, &SolvedContact::kind),
    Field({.name = "reaction", .range = kReaction}, &tool_contact_t::reaction,
          &SolvedContact::reaction),
    Field({"shaft_contact"}, &tool_contact_t::shaft_contact, &SolvedContact::shaft_contact),
    Field({"contact_W"}, &tool_contact_t::p_contact, &SolvedContact::contact_W),
    Field({"force_on_tissue_W"}, &tool_contact_t::force_on_tissue,
          &SolvedContact::force_on_tissue_W),
    Field({"p_original_W"}, &tool_contact_t::p_original, &SolvedContact::p_original_W),
    Field({"normal_W"}, &tool_contact_t::normal, &SolvedContact::normal_W),
    Field({"compliance_W"}, &tool_contact_t::compliance, &SolvedContact::compliance_W),
    Field({"coupling_W"}, &tool_contact_t::coupling, &SolvedContact::coupling_W),
    Field({"kernel_radius"}, &tool_contact_t::kernel_radius, &SolvedContact::kernel_radius)};
inline constexpr std::tuple kBeside{
    Field({"beside.organ"}, &beside_contact_t::organ, &SolvedContact::organ),
    Field({"beside.contact_W"}, &beside_contact_t::p_contact, &SolvedContact::contact_W),
    Field({"beside.force_on_tissue_W"}, &beside_contact_t::force_on_tissue,
          &SolvedContact::force_on_tissue_W),
    Field({"beside.normal_W"}, &beside_contact_t::normal, &SolvedContact::normal_W)};

}  // namespace logged

/// Calls visit(field) for every field of one of the lists above, in order.
template <typename Fields, typename Visit>
void VisitFields(const Fields& fields, Visit&& visit) {
  std::apply([&](const auto&... field) { (visit(field), ...); }, fields);
}

/// Calls visit(tool, field, value...) for every field of a list, with the value in each object.
template <typename Fields, typename Visit, typename... Objects>
void VisitValues(const Fields& fields, int tool, Visit&& visit, Objects&... objects) {
  VisitFields(fields, [&](const auto& field) { visit(tool, field, objects.*field.sample...); });
}

/// Visits the logged input of ticks as VisitValues does. `tool` is -1 for a field of the tick. Like
/// the following, it visits the first sample's tools in each.
template <typename Visit, typename Sample, typename... Samples>
void VisitInput(Visit&& visit, Sample& first, Samples&... others) {
  VisitValues(logged::kTickInput, -1, visit, first, others...);
  VisitValues(logged::kRestart, -1, visit, first.restart, others.restart...);
  VisitValues(logged::kSkipped, -1, visit, first.skipped, others.skipped...);
  for (int t = 0; t < first.tool_count; ++t) {
    VisitValues(logged::kToolInput, t, visit, first.tools[t], others.tools[t]...);
  }
}

/// Visits the logged output of ticks.
template <typename Visit, typename Sample, typename... Samples>
void VisitOutput(Visit&& visit, Sample& first, Samples&... others) {
  VisitValues(logged::kTickOutput, -1, visit, first, others...);
  for (int t = 0; t < first.tool_count; ++t) {
    VisitValues(logged::kToolOutput, t, visit, first.tools[t], others.tools[t]...);
  }
}

/// Visits the logged fields of steps.
template <typename Visit, typename Sample, typename... Samples>
void VisitStep(Visit&& visit, Sample& first, Samples&... others) {
  VisitValues(logged::kStep, -1, visit, first.step, others.step...);
  for (int o = 0; o < first.organ_count; ++o) {
    VisitValues(logged::kRelaxation, -1, visit, first.organs[o], others.organs[o]...);
  }
  for (int a = 0; a < first.attachment_count; ++a) {
    VisitValues(logged::kAttachment, -1, visit, first.attachments[a], others.attachments[a]...);
  }
  for (int d = 0; d < first.duct_count; ++d) {
    VisitValues(logged::kDuct, -1, visit, first.ducts[d], others.ducts[d]...);
  }
  for (int t = 0; t < first.tool_count; ++t) {
    visit(t, FieldInfo{"X_WT"}, first.tools[t].X_WT, others.tools[t].X_WT...);
    VisitValues(logged::kPose, t, visit, first.tools[t], others.tools[t]...);
    VisitValues(logged::kContact, t, visit, first.contacts[t], others.contacts[t]...);
    VisitValues(logged::kLayerWork, t, visit, first.layer_work[t], others.layer_work[t]...);
    VisitValues(logged::kDuctAction, t, visit, first.duct_actions[t], others.duct_actions[t]...);
    VisitValues(logged::kNearDuct, t, visit, first.near_ducts[t], others.near_ducts[t]...);
    for (std::size_t b = 0; b < first.beside[t].size(); ++b) {
      VisitValues(logged::kBeside, t, visit, first.beside[t][b], others.beside[t][b]...);
    }
  }
  VisitValues(logged::kResidual, -1, visit, first.step, others.step...);
}

}  // namespace hpdm
