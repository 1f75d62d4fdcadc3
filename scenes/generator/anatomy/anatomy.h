#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scenes/generator/organ_mesh.h"
#include "scenes/generator/shapes/implicit_shapes.h"
#include "scenes/generator/texturing/organ_colours.h"

namespace hpdm {

/// How ducts and arteries run beside the gallbladder.
enum class AnatomyVariant {
  kUsual,          ///< A cystic duct of about 31 mm; the artery lies behind the common duct.
  kShortDuct,      ///< A cystic duct of about 14 mm draws the common duct towards the gallbladder.
  kArteryInFront,  ///< The right hepatic artery crosses in front of the common duct.
  kLowUnion,       ///< The cystic duct runs beside the common duct and joins it far below.
};

/// Names of the variants, as `hpdm generate --anatomy` takes them.
inline constexpr std::pair<std::string_view, AnatomyVariant> kAnatomyVariants[] = {
    {"usual", AnatomyVariant::kUsual},
    {"short_duct", AnatomyVariant::kShortDuct},
    {"artery_in_front", AnatomyVariant::kArteryInFront},
    {"low_union", AnatomyVariant::kLowUnion}};

/// The organs around a gallbladder, before its removal. World frame: that of the liver
/// (implicit_shapes.h). The liver is LiverShape(); the others vary with the seed. Seed 0 has the
/// mean sizes. Only + - * / and sqrt are used: the same bits on every x86-64 machine.
struct Anatomy {
  struct Organ {
    std::string name;  ///< Also of its files, with "_" for a space.
    std::shared_ptr<const ImplicitShape> shape;
    OrganMeshOptions mesh;
    std::function<SurfaceColour()> colour;  ///< Made when it is needed: vessels grow slowly.
  };
  /// A duct or vessel between two organs.
  struct Tube {
    std::string name;
    std::string a, b;            ///< Names of the organs at its ends.
    std::vector<Vector3d> path;  ///< m, world: its middle line, from a's tissue to b's.
    double radius = 0;           ///< m, outer.
    double wall = 0;             ///< m.
    double young = 0;            ///< Pa.
    Vector3d colour;             ///< Red, green and blue, 0..1.
  };

  /// A sheet of peritoneum between lines on two organs, both from the body to the neck.
  struct Leaf {
    std::vector<Vector3d> on_gallbladder, on_liver;  ///< m, world.
  };

  Anatomy(AnatomyVariant variant, std::uint64_t seed);

  /// The gallbladder with Hartmann's pouch, in its own frame; turned about x by kTilt degrees, its
  /// origin then is at `gallbladder_position`.
  Organ gallbladder;
  Vector3d gallbladder_position;  ///< m.
  /// World frame, rigid: hepatic and common bile duct, right hepatic artery, the fat ligament around
  /// the duct's lower part, the lymph node in Calot's triangle.
  std::vector<Organ> fixed;
  std::vector<Tube> tubes;  ///< The cystic duct and the cystic artery.
  Leaf leaf;                ///< The front leaf over Calot's triangle.
  Vector3d fundus;          ///< m, world: its end below the liver's border.

  static constexpr double kTilt = -20;  ///< Degrees.
  static constexpr double kTiltTurns = kTilt / 360;
};

}  // namespace hpdm
