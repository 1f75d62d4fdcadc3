#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "engine/base/check.h"
#include "engine/base/types.h"
#include "haptics/device/simulated_hand.h"

namespace hpdm {

/// Continuous interpolation of N values that change together (the tip's place; the roll; the jaw)
/// from their rows in a trace. The header trace_motion.h explains the treatment of repeats and
/// gaps.
///
/// Built by Add in the order of time, then Finish. Constant after that; any thread may read it.
template <int N>
class TraceTrack {
 public:
  using Values = Eigen::Matrix<double, N, 1>;
  struct Knot {
    Nanoseconds time_ns = 0;
    Values values = Values::Zero();
    Values slope = Values::Zero();  ///< 1/s.
    bool gap = false;               ///< True if a gap follows this knot.
  };

  /// Adds a row; `gap` is true if a gap or the end follows it. Drops repeats shorter than `pause`.
  void Add(Nanoseconds time, const Values& values, bool gap, Nanoseconds pause) {
    const bool repeats = !knots_.empty() && !knots_.back().gap && knots_.back().values == values;
    if (!repeats) {
      Close(pause);
      knots_.push_back({time, values, Values::Zero(), false});
    }
    last_ns_ = time;
    if (!gap) return;
    Close(0);
    knots_.back().gap = true;
  }

  /// Computes the slopes. Call after the last row, which was added with `gap`.
  void Finish() {
    HPDM_CHECK(!knots_.empty() && knots_.back().gap);
    for (std::size_t i = 1; i + 1 < knots_.size(); ++i) {
      if (knots_[i].gap || knots_[i - 1].gap) continue;
      const Values before = Secant(i - 1), after = Secant(i);
      for (int d = 0; d < N; ++d) {
        if (before[d] * after[d] > 0) {
          knots_[i].slope[d] = 2 * before[d] * after[d] / (before[d] + after[d]);
        }
      }
    }
  }

  /// Returns the values at `time`. `cursor` is the caller's last position, 0 at first: a small
  /// advance in time is found at once, other times by bisection. Wait-free, no allocation.
  Values At(Nanoseconds time, std::size_t* cursor) const noexcept {
    if (time <= knots_.front().time_ns) return knots_.front().values;
    if (time >= knots_.back().time_ns) return knots_.back().values;
    const auto holds = [&](std::size_t i) {
      return i + 1 < knots_.size() && knots_[i].time_ns <= time && time < knots_[i + 1].time_ns;
    };
    if (!holds(*cursor) && !holds(++*cursor)) {
      const auto later =
          std::upper_bound(knots_.begin(), knots_.end(), time,
                           [](Nanoseconds t, const Knot& knot) { return t < knot.time_ns; });
      *cursor = static_cast<std::size_t>(later - knots_.begin()) - 1;
    }
    const Knot &a = knots_[*cursor], &b = knots_[*cursor + 1];
    const double h = ToSeconds(b.time_ns - a.time_ns);
    const double s = ToSeconds(time - a.time_ns) / h;
    const Values d = b.values - a.values, m0 = h * a.slope, m1 = h * b.slope;
    Values value = a.values;
    if (a.gap) {
      value += MinimumJerk::Position(s) * d;
    } else {
      value += s * (m0 + s * (3 * d - 2 * m0 - m1 + s * (m0 + m1 - 2 * d)));
    }
    // Both pieces are monotone; clamping removes rounding errors.
    return value.cwiseMax(a.values.cwiseMin(b.values)).cwiseMin(a.values.cwiseMax(b.values));
  }

  const std::vector<Knot>& knots() const { return knots_; }

  /// Largest |secant| outside gaps, 1/s.
  double Fastest() const {
    double fastest = 0;
    for (std::size_t i = 0; i + 1 < knots_.size(); ++i) {
      if (!knots_[i].gap) fastest = std::max(fastest, Secant(i).norm());
    }
    return fastest;
  }

 private:
  // Ends the run of repeats that began at the last knot. A rest of at least `pause` keeps its end.
  void Close(Nanoseconds pause) {
    if (knots_.empty() || knots_.back().gap) return;
    const Knot& first = knots_.back();
    if (last_ns_ > first.time_ns && last_ns_ - first.time_ns >= pause) {
      knots_.push_back({last_ns_, Values(first.values), Values::Zero(), false});
    }
  }

  Values Secant(std::size_t i) const {
    return (knots_[i + 1].values - knots_[i].values) /
           ToSeconds(knots_[i + 1].time_ns - knots_[i].time_ns);
  }

  std::vector<Knot> knots_;
  Nanoseconds last_ns_ = 0;  // time of the newest row
};

}  // namespace hpdm
