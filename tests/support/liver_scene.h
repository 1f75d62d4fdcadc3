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
/// Returns a probe with the given lines of keys of its simulated hand and of its own.
inline std::string Probe(const std::string& hand, const std::string& own = "") {
  return "\n[[instrument]]\nname = \"probe\"\ntrocar = [0.05, -0.12, 0.16]\n" + own +
         "  [instrument.hand]\n" + hand;
}
/// Returns a grasper with the given lines of keys of its simulated hand.
inline std::string Grasper(const std::string& hand) {
  return "\n[[instrument]]\nname = \"grasper\"\ntype = \"grasper\"\n"
         "trocar = [-0.06, -0.12, 0.15]\n  [instrument.hand]\n" +
         hand;
}
/// A probe whose simulated hand palpates the liver.
inline const std::string kPalpatingProbe = Probe("script = \"palpate\"\nspeed = 0.3\n");
/// A grasper whose simulated hand pulls at the liver.
inline const std::string kPullingGrasper = Grasper("script = \"grasp_pull\"\nspeed = 0.3\n");

}  // namespace hpdm
