#pragma once

#include <string>

namespace hpdm {

// Parts of small scenes: an organ, its support, and the instruments, in this order. Keys that follow
// a part belong to it.

/// A liver of 274 triangles, by its path in the source tree.
inline const std::string kLiver =
    "[[organ]]\nname = \"liver\"\nmesh = \"" HPDM_SOURCE_DIR "/scenes/meshes/liver_274.obj\"\n";
/// The same with the energy that is the fastest to build.
inline const std::string kMetricLiver = kLiver + "energy.type = \"metric\"\n";
/// Holds the organ's rear.
inline const std::string kRearSupport = R"(
  [[organ.support]]
  box_fraction = { min = [0.0, 0.7, 0.0], max = [1.0, 1.0, 1.0] }
  fixed = true
)";
/// A probe whose simulated hand palpates the liver.
inline const std::string kPalpatingProbe = R"(
[[instrument]]
name = "probe"
trocar = [0.05, -0.12, 0.16]
  [instrument.hand]
  script = "palpate"
  speed = 0.3
)";
/// A grasper whose simulated hand pulls at the liver.
inline const std::string kPullingGrasper = R"(
[[instrument]]
name = "grasper"
type = "grasper"
trocar = [-0.06, -0.12, 0.15]
  [instrument.hand]
  script = "grasp_pull"
  speed = 0.3
)";

}  // namespace hpdm
