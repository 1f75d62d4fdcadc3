#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "engine/base/types.h"

namespace hpdm {

/// Motion and force of one instrument: tip (world, m), pitch and yaw (rad), insertion (m), roll
/// (rad), force on the hand (world, N).
inline constexpr int kMotionRows = 10;
using MotionVector = Eigen::Matrix<double, kMotionRows, 1>;
enum MotionRow {
  kMotionTip = 0,
  kMotionPitch = 3,
  kMotionYaw,
  kMotionInsertion,
  kMotionRoll,
  kMotionForce
};

/// An uninterrupted, evenly sampled part of one instrument's time series.
struct TimeSeriesSegment {
  double start = 0;  ///< s, time of the first sample; in a report since the first tick.
  std::vector<MotionVector> samples;  ///< Every kMotionPeriod.
};

/// Sampling period of a time series, s.
inline constexpr double kMotionPeriod = 0.005;
/// Ticks further apart than this end a segment, s.
inline constexpr double kMotionGap = 0.1;

/// Resamples ticks of any times to evenly sampled segments. The ticks' values are interpolated
/// linearly and averaged exactly over each kMotionPeriod, so skipped ticks and the loop's rate have
/// no effect. The average's gain at frequency f is sinc(f kMotionPeriod), 0.996 at 10 Hz. One
/// thread.
class UniformTimeSeries {
 public:
  /// Adds a tick. Times rise; values are finite.
  void Add(double time, const MotionVector& value);
  /// Ends the segment: the next tick begins a new one.
  void Break();
  /// Returns the segments, each with at least one sample. Call Break() first.
  const std::vector<TimeSeriesSegment>& segments() const { return segments_; }

 private:
  bool joined_ = false;  // the segment has a tick
  double origin_ = 0;    // time of the segment's first tick, where its grid begins
  double last_time_ = 0;
  MotionVector last_ = MotionVector::Zero();
  MotionVector sum_ = MotionVector::Zero();  // integral over the present sample
  TimeSeriesSegment segment_;
  std::vector<TimeSeriesSegment> segments_;
};

/// Smooths evenly sampled values in place without delay: a second-order Butterworth filter runs
/// forwards, then backwards (together -3 dB at `cutoff`, Hz). Each end is continued by its point
/// reflection, and each pass begins at rest on its first value. Straight lines do not change. D. A.
/// Winter, Biomechanics and Motor Control of Human Movement, 4th ed. (2009), 3.4.4.
void SmoothZeroPhase(double cutoff, double period, std::vector<MotionVector>* samples);

}  // namespace hpdm
