#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "engine/base/types.h"

namespace hpdm {

/// What moves of one instrument, one number a row: tip (world, m), pitch, yaw (rad), insertion (m),
/// roll (rad), force on the hand (world, N).
inline constexpr int kCourseRows = 10;
using CourseVector = Eigen::Matrix<double, kCourseRows, 1>;
enum CourseRow {
  kCourseTip = 0,
  kCoursePitch = 3,
  kCourseYaw,
  kCourseInsertion,
  kCourseRoll,
  kCourseForce
};

/// An uninterrupted part of one instrument's course, evenly sampled.
struct CourseStretch {
  double start = 0;                   ///< s, session time of the first sample.
  std::vector<CourseVector> samples;  ///< Every kCoursePeriod.
};

/// Sampling period of a course, s.
inline constexpr double kCoursePeriod = 0.005;
/// Ticks further apart than this end a stretch, s: what happened between them is not guessed.
inline constexpr double kCourseGap = 0.1;

/// Makes evenly sampled stretches of ticks that come at any times: the ticks' values are joined by
/// straight lines and averaged over each kCoursePeriod, exactly, so that skipped ticks and the
/// loop's rate leave no trace. The average is a filter too: its gain at f is sinc(f kCoursePeriod),
/// 0.996 at 10 Hz. One thread.
class UniformCourse {
 public:
  /// Times rise; values are finite.
  void Add(double time, const CourseVector& value);
  /// The next tick begins a new stretch.
  void Break();

  /// Of at least one sample each. Call Break() first.
  const std::vector<CourseStretch>& stretches() const { return stretches_; }

 private:
  bool joined_ = false;  // there is a tick before
  double origin_ = 0;    // of the grid: the stretch's first tick
  double last_time_ = 0;
  CourseVector last_ = CourseVector::Zero();
  CourseVector sum_ = CourseVector::Zero();  // integral over the sample under way
  CourseStretch stretch_;
  std::vector<CourseStretch> stretches_;
};

/// Smooths evenly sampled values in place, without shifting them in time: a Butterworth filter of
/// second order forwards, then backwards (together -3 dB at `cutoff`, Hz), each end continued by
/// its point reflection and each pass begun at rest on its first value. A straight line stays as it
/// is. D. A. Winter, Biomechanics and Motor Control of Human Movement, 4th ed. (2009), 3.4.4.
void SmoothZeroPhase(double cutoff, double period, std::vector<CourseVector>* samples);

}  // namespace hpdm
