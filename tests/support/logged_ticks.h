#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>

#include "lcmtypes/log/log.h"
#include "lcmtypes/wire/codec.h"

namespace hpdm {

//// Facts of the haptic ticks in a session's log.
struct LoggedTicks {
  std::uint64_t count = 0;
  std::uint64_t gaps = 0;           /// numbers that are neither logged nor counted as skipped
  std::uint64_t grasping = 0;       /// ticks with tissue in the jaws
  double largest_force_step = 0;    /// N, from tick to tick
  double largest_displacement = 0;  /// m, of a control point
};

/// Reads a session's log; without ticks if a message cannot be decoded.
inline LoggedTicks ReadTicks(const std::filesystem::path& log) {
  LogReader reader(log.string());
  LogEvent event;
  force_t message;
  HapticSample sample;
  LoggedTicks ticks;
  std::uint64_t next = 0;
  std::array<Vector3d, kMaxInstruments> last;
  last.fill(Vector3d::Zero());
  while (reader.Next(&event)) {
    if (event.channel == kOrganChannel) {
      organ_t organ;
      OrganSnapshot shape;
      if (!DecodeMessage(event.data, &organ) || !FromMessage(organ, &shape)) return {};
      if (shape.control_displacements.rows() == 0) continue;  // a rigid organ
      ticks.largest_displacement = std::max(
          ticks.largest_displacement, shape.control_displacements.rowwise().norm().maxCoeff());
    }
    if (event.channel == kToolChannel) {
      tool_t input;
      if (!DecodeMessage(event.data, &input) || !FromMessage(input, &sample)) return {};
    }
    if (event.channel != kForceChannel) continue;
    if (!DecodeMessage(event.data, &message) || !FromMessage(message, &sample)) return {};
    ++ticks.count;
    if (sample.tick != next + sample.skipped.Total()) ++ticks.gaps;
    next = sample.tick + 1;
    for (int t = 0; t < sample.tool_count; ++t) {
      ticks.grasping += sample.tools[t].kind == ContactKind::kGrasp;
      const Vector3d& force = sample.tools[t].force_W;
      ticks.largest_force_step = std::max(ticks.largest_force_step, (force - last[t]).norm());
      last[t] = force;
    }
  }
  EXPECT_EQ(reader.damaged_stretches(), 0u);
  return ticks;
}

}  // namespace hpdm
