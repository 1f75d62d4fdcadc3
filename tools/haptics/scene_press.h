#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "tools/haptics/organ_trials.h"

/// Presses of a tool on the organs of a scene, for the tables of `hpdm haptics` and `hpdm bench`.
namespace hpdm {

/// A press in a scene: from 5 mm above the surface point of an organ that is nearest to `place`,
/// against the normal there, or along `direction` if it is not zero.
struct ScenePress {
  std::string name;
  std::string organ;
  Vector3d place_W = Vector3d::Zero();      ///< m.
  Vector3d direction_W = Vector3d::Zero();  ///< Unit, into the organ.
  double tip_radius = 0.005;                ///< m.
  double speed = 0.1;                       ///< m/s.
  double friction = 0.1;                    ///< Coulomb coefficient of the tip.
  bool all_pairs = false;  ///< Soft organs touch each other too where the scene lets them pass.
};
struct ScenePressResult {
  Penetration penetration;
  double pair_force = 0;    ///< N: largest sum of the forces of one organ on another.
  double felt = 0;          ///< N: largest force on the hand.
  double largest_jump = 0;  ///< N: largest change of the force on the hand in a tick.
  bool dropped = false;     ///< A step had no room for all contacts.
};
/// Presses to `depth` (m), holds for 0.5 s and lets go, as a session in lockstep does: ticks of 1 ms
/// follow the contact under the tip, and a step takes it over every 33 ticks. The tool is a tip
/// without a shaft; the scene's own tools are away. `seen` is called after each step, if given.
ScenePressResult PressInScene(const std::filesystem::path& scene, const ScenePress& press,
                              double depth, const std::function<void(OrganBench*)>& seen = nullptr);

}  // namespace hpdm
