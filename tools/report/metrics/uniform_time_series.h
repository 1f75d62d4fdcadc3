#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "engine/base/types.h"

namespace hpdm {

/// What moves of one instrument, one number a row: tip (world, m), pitch, yaw (rad), insertion (m),
/// roll (rad), force on the hand (world, N).
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

/// An uninterrupted part of one instrument's time series, evenly sampled.
struct TimeSeriesSegment {
  double start = 0;                   ///< s, session time of the first sample.
  std::vector<MotionVector> samples;  ///< Every kMotionPeriod.
};

/// Sampling period of a time series, s.
inline constexpr double kMotionPeriod = 0.005;
/// Ticks further apart than this end a segment, s: what happened between them is not guessed.
inline constexpr double kMotionGap = 0.1;

/// Makes evenly sampled segments of ticks that come at any times: the ticks' values are joined by
/// straight lines and averaged over each kMotionPeriod, exactly, so that skipped ticks and the
/// loop's rate leave no trace. The average is a filter too: its gain at f is sinc(f kMotionPeriod),
/// 0.996 at 10 Hz. One thread.
class UniformTimeSeries {
 public:
  /// Times rise; values are finite.
  void Add(double time, const MotionVector& value);
  /// The next tick begins a new segment.
  void Break();

  /// Of at least one sample each. Call Break() first.
  const std::vector<TimeSeriesSegment>& segments() const { return segments_; }

 private:
  bool joined_ = false;  // there is a tick before
  double origin_ = 0;    // of the grid: the segment's first tick
  double last_time_ = 0;
  MotionVector last_ = MotionVector::Zero();
  MotionVector sum_ = MotionVector::Zero();  // integral over the sample under way
  TimeSeriesSegment segment_;
  std::vector<TimeSeriesSegment> segments_;
};

/// Smooths evenly sampled values in place, without shifting them in time: a Butterworth filter of
/// second order forwards, then backwards (together -3 dB at `cutoff`, Hz), each end continued by
/// its point reflection and each pass begun at rest on its first value. A straight line stays as it
/// is. D. A. Winter, Biomechanics and Motor Control of Human Movement, 4th ed. (2009), 3.4.4.
void SmoothZeroPhase(double cutoff, double period, std::vector<MotionVector>* samples);

}  // namespace hpdm
