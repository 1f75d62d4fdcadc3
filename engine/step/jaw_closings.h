#pragma once

#include <algorithm>
#include <array>

#include "engine/snapshots.h"

namespace hpdm {

/// Finds the steps in which the jaws of the tools close (kJawGrasps), and how wide they have been since
/// they were last closed. Another instrument begins with closed jaws. One thread; allocates nothing.
class JawClosings {
 public:
  /// Takes the tools of the next step.
  void Follow(const std::array<ToolPose, kMaxInstruments>& tools, int tool_count) {
    closing_.fill(0);
    for (int t = 0; t < tool_count; ++t) {
      const ToolPose& pose = tools[ToSize(t)];
      Jaws& jaws = jaws_[ToSize(t)];
      if (pose.instrument_index != jaws.instrument_index) jaws = {pose.instrument_index, 0};
      if (pose.jaw >= kJawGrasps) {
        jaws.widest = std::max(jaws.widest, pose.jaw);
      } else {
        closing_[ToSize(t)] = jaws.widest;
        jaws.widest = 0;
      }
    }
  }
  /// Returns the largest opening, up to 1, from which the tool's jaws close in this step; 0: they do
  /// not close.
  double ClosingFrom(std::size_t tool) const { return closing_[tool]; }

 private:
  struct Jaws {
    int instrument_index = 0;
    double widest = 0;  // since they were last closed; 0: closed
  };
  std::array<Jaws, kMaxInstruments> jaws_{};
  std::array<double, kMaxInstruments> closing_{};
};

}  // namespace hpdm
