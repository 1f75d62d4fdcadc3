#pragma once

#include <vector>

#include "engine/snapshots.h"
#include "engine/step/tip_press.h"
#include "engine/step/tool_geometry.h"

namespace hpdm {

/// One instrument's data for the deformation loop.
struct ToolOptions {
  std::vector<ToolGeometry> geometries = {ToolGeometry()};  ///< [ToolPose::instrument_index]
  double prefetch = 0.05;  ///< s from a step's input to the middle of its patch's use. The use
                           ///< begins one period later and lasts one period.
  ReactionType reaction = ReactionType::kLattice;
  double k1 = 120;              ///< N/m, Eq. 29 with rest neighbours (kPaper).
  double k2 = 10;               ///< N/m.
  double wall_stiffness = 200;  ///< N/m: virtual wall of a rigid organ, for either reaction.
  /// [organ]: the walls of rigid organs, instead of wall_stiffness; none, or empty ones, where that
  /// holds.
  std::vector<WallField> walls = {};
};

}  // namespace hpdm
