#pragma once

#include <array>
#include <cstdint>

#include "engine/base/types.h"

namespace hpdm {

/// Most nodes of a duct, those that cuts add included.
inline constexpr int kMaxDuctNodes = 45;

/// A segment of a duct: its lumen is open, or a clip closes it, or it is the gap of a cut.
enum class SegmentState : std::uint8_t { kOpen = 0, kClipped = 1, kGap = 2 };

/// A duct after a step (duct_options.h).
struct DuctOutcome {
  Vector3d load_W = Vector3d::Zero();  ///< N: force of the duct on what holds its end b.
  double tension = 0;                  ///< N: the largest in its segments.
  double length = 0;                   ///< m, without gaps.
  std::int32_t clips = 0;
  std::int32_t cuts = 0;
};

/// A duct after a step, to be drawn.
struct DuctSnapshot {
  int nodes = 0;
  std::array<Eigen::Vector3f, kMaxDuctNodes> nodes_W;  ///< m.
  std::array<SegmentState, kMaxDuctNodes> segments{};  ///< That after each node.
};

}  // namespace hpdm
