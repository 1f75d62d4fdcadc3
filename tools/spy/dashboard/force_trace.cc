#include "tools/spy/dashboard/force_trace.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hpdm {
namespace {

// Returns 0 for a value beyond the range of single precision, which the rows have.
double Finite(double value) {
  return std::abs(value) <= std::numeric_limits<float>::max() ? value : 0;
}

}  // namespace

void ForceTrace::Add(const force_t& force) {
  if (begin_ns_ < 0) begin_ns_ = force.time_ns;
  const std::int64_t interval = force.time_ns / kInterval;
  if (filling_any_ && interval > filling_.interval) Finish();
  if (!filling_any_ && (rows_.empty() || interval > rows_.back().interval)) {
    filling_ = {};
    filling_.interval = interval;
    filling_any_ = true;
  }
  const bool fits = filling_any_ && filling_.interval == interval;
  if (fits) filling_.tool_count = std::max(filling_.tool_count, force.tool_count);
  for (int i = 0; i < force.tool_count; ++i) {
    const tool_force_t& tool = force.tools[i];
    const double* f = tool.force;
    const double newton = Finite(std::sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]));
    const double depth = Finite(tool.depth);
    peaks_[i].force = std::max(peaks_[i].force, newton);
    peaks_[i].depth = std::max(peaks_[i].depth, depth);
    if (!fits) continue;
    filling_.force[i] = std::max(filling_.force[i], static_cast<float>(newton));
    filling_.depth[i] = std::max(filling_.depth[i], static_cast<float>(depth));
    filling_.guard_flags[i] |= static_cast<std::uint32_t>(tool.guard_flags);
  }
}

void ForceTrace::Finish() {
  if (!filling_any_) return;
  rows_.push_back(filling_);
  filling_any_ = false;
  if (rows_.size() > kMaxRows) {
    rows_.pop_front();
    ++dropped_;
  }
}

}  // namespace hpdm
