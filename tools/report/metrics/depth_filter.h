#pragma once

#include "engine/snapshots.h"

namespace hpdm {

/// Decides which of a tip's depths are presses by its hand. A tick's depth is the distance of the tip
/// below the released surface, so it is also large where the surface jumps over the tip. It does not
/// count from a tick on in which it grows by more than the tip has moved and tissue can have moved:
/// kJump + kTissueSpeed x time. It counts again once it is at most kJump above the depth before.
///
/// Of one tip; ticks in order.
class DepthFilter {
 public:
  static constexpr double kJump = 0.010;       ///< m.
  static constexpr double kTissueSpeed = 0.3;  ///< m/s.

  /// Adds a tick at `time` (s) that has its output. True if its depth counts.
  bool Add(double time, const ToolSample& tool);
  /// What the last Add() returned; true before the first.
  bool counts() const { return !jumped_; }

 private:
  bool begun_ = false, jumped_ = false;
  double time_ = 0;                      // s, of the last tick
  double depth_ = 0;                     // m
  double depth_before_ = 0;              // m, before the jump
  Vector3d p_tip_W_ = Vector3d::Zero();  // m
};

}  // namespace hpdm
