#pragma once

#include <array>
#include <cstdint>
#include <limits>

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

/// Effect of an instrument on a duct when its jaws close.
enum class DuctActionKind : std::uint8_t {
  kNone = 0,
  kClip = 1,      ///< A clip closes the duct.
  kLostClip = 2,  ///< A clip falls: no duct is between the jaws, or it takes no clip there.
  kCut = 3
};

/// Action of one instrument on a duct in one step.
struct DuctAction {
  DuctActionKind kind = DuctActionKind::kNone;
  std::int32_t duct = -1;  ///< Number of the duct in the scene; -1: none.
  double arc = 0;          ///< m: place along the duct at rest, from its end a.
  double length = 0;       ///< m: of the duct at rest.
  double angle = 0;        ///< rad: between the plane of the jaws and the duct's normal plane.
  /// Share of the lumen's width, flattened between the jaws, that lies within their length.
  double coverage = 0;
  Vector3d place_W =
      Vector3d::Zero();  ///< m: of the duct between the jaws; of a lost clip the tip.
};

/// The clips beside a place on a duct.
struct ClipsBeside {
  /// m along the duct at rest to the middle of the nearest clip; infinity without one.
  double gap = std::numeric_limits<double>::infinity();
  int before = 0, after = 0;  ///< How many lie towards the duct's end a and its end b.
};

/// The duct that is nearest to an energised hook in one step.
struct NearDuct {
  std::int32_t duct = -1;  ///< Number of the duct in the scene; -1: the hook is not energised.
  double gap = 0;          ///< m: between its surface and the tip's, below 0 if they overlap.
};

/// A duct after a step, to be drawn.
struct DuctSnapshot {
  int nodes = 0;
  std::array<Eigen::Vector3f, kMaxDuctNodes> nodes_W;  ///< m.
  std::array<SegmentState, kMaxDuctNodes> segments{};  ///< That after each node.
};

}  // namespace hpdm
