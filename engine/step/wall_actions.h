#pragma once

#include <array>
#include <span>
#include <vector>

#include "engine/snapshots.h"
#include "engine/step/jaw_closings.h"
#include "engine/step/organ_step.h"
#include "engine/step/tool_options.h"

namespace hpdm {

/// Perforates the walls of filled lumens by the instruments, once a step, where the last step left
/// the organs. The wall is as thick as the nearest lumen's inner surface is far from the tip's contact.
///
/// 1. An energised hook that presses an organ burns a hole of kHoleArea through its wall once it has
///    brought kBurning x kHoleArea x thickness into it at one place. A hook that burns a layer spares
///    the wall (layer_actions.h). The heat of one that leaves, lets go or finds a layer is lost.
/// 2. Scissors that close while their tip presses an organ cut a wall that is thinner than their
///    blades are long.
///
/// Nothing else perforates: no press, no pull, no jaws. Deformation thread; allocates nothing after
/// construction.
class WallActions {
 public:
  static constexpr double kHoleArea = 3e-6;       ///< m^2.
  static constexpr double kBurning = 1.9e9;       ///< J/m^3: heats tissue and vaporises its water.
  static constexpr double kSamePlace = 0.002;     ///< m.
  static constexpr double kLongestBurning = 0.1;  ///< s: a late step burns no longer than this.

  explicit WallActions(const std::vector<ToolOptions>& tools);

  /// Applies the tools of a step, `dt` (s) after the last, whose jaws `jaws` follows. `contacts`: of
  /// the last step, in the world; `work`: on layers in this step.
  void Apply(const ToolState& tools, const JawClosings& jaws, double dt,
             std::span<const SolvedContact> contacts, std::span<const LayerWork> work,
             std::vector<OrganStep>* organs);

 private:
  struct Tool {
    std::vector<ToolGeometry> geometries;
    double heat = 0;                  // J, brought into the place
    Vector3d p_W = Vector3d::Zero();  // m, where it is
  };
  std::vector<Tool> tools_;
};

}  // namespace hpdm
