#include "haptics/device/trace_motion.h"

#include <algorithm>

#include "engine/base/check.h"

namespace hpdm {
namespace {

constexpr Nanoseconds kMinPause = 50'000'000;
constexpr Nanoseconds kPauseIntervals = 4;

Nanoseconds Pause(const std::vector<TraceRow>& rows) {
  std::vector<Nanoseconds> intervals;
  intervals.reserve(rows.size());
  for (std::size_t i = 1; i < rows.size(); ++i) {
    intervals.push_back(rows[i].time_ns - rows[i - 1].time_ns);
  }
  if (intervals.empty()) return kMinPause;
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  return std::max(kMinPause, kPauseIntervals * *middle);
}

}  // namespace

TraceMotion::TraceMotion(const std::vector<TraceRow>& rows) {
  HPDM_CHECK(!rows.empty());
  const Nanoseconds pause = Pause(rows);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto& [time, values] = rows[i];
    const bool is_last = i + 1 == rows.size();
    const Nanoseconds interval = is_last ? 0 : rows[i + 1].time_ns - time;
    const bool gap = is_last || interval > pause;
    if (gap && !is_last) {
      ++gaps_.count;
      gaps_.longest_ns = std::max(gaps_.longest_ns, interval);
    }
    place_.Add(time, values.head<3>(), gap, pause);
    roll_.Add(time, values.segment<1>(kRoll), gap, pause);
    jaw_.Add(time, values.segment<1>(kJaw), gap, pause);
  }
  place_.Finish();
  roll_.Finish();
  jaw_.Finish();
  duration_ = rows.back().time_ns;
}

JointVector TraceMotion::At(Nanoseconds time, Cursor* cursor) const noexcept {
  JointVector values;
  values << place_.At(time, &cursor->place), roll_.At(time, &cursor->roll),
      jaw_.At(time, &cursor->jaw);
  return values;
}

}  // namespace hpdm
