#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "tools/report/metrics/uniform_time_series.h"

namespace hpdm {

/// Motion figures of one instrument. Definitions, filters and sources: tools/report/README.md.
struct MotionMetrics {
  double time = 0;            ///< s, duration of the samples.
  double path_length = 0;     ///< m, of the tip.
  double angular_path = 0;    ///< rad, of the shaft about the trocar.
  double roll_path = 0;       ///< rad, about the shaft.
  double insertion_path = 0;  ///< m, along the shaft ("depth").
  double mean_speed = 0;      ///< m/s, path_length / time.
  double peak_speed = 0;      ///< m/s.
  double idle = 0;            ///< s of motion slower than kIdleSpeed.
  std::uint64_t movements = 0;
  std::uint64_t advances = 0;        ///< Along the shaft, of at least kAdvance.
  std::uint64_t overshoots = 0;      ///< Advances through the air that were corrected.
  std::optional<double> economy;     ///< 0..1: distance / path of the movements; nothing without.
  std::optional<double> smoothness;  ///< SPARC, median of the movements up to kDiscreteMovement.
  double mean_force_rate = 0;        ///< N/s, mean |dF/dt| while there is a force.
  double peak_force_rate = 0;        ///< N/s.
};

/// Cut-off of the smoothing, Hz.
inline constexpr double kMotionCutoff = 10;
/// A tip slower than this is idle, m/s.
inline constexpr double kIdleSpeed = 0.005;
/// A movement is faster than kIdleSpeed for at least kMovementTime, s, and its peak speed is at
/// least kMovementSpeed, m/s.
inline constexpr double kMovementTime = 0.1;
inline constexpr double kMovementSpeed = 0.01;
/// To measure smoothness, a movement is extended at both ends until its speed falls to this
/// fraction of its peak.
inline constexpr double kMovementEdge = 0.01;
/// Longest discrete movement, s. SPARC is defined for discrete movements only.
inline constexpr double kDiscreteMovement = 10;
/// Forces below this count as none, N: far below what a hand can feel.
inline constexpr double kNoForce = 0.01;

/// An advance is a way along the shaft into the body of at least this length, m.
inline constexpr double kAdvance = 0.01;
/// An advance overshot its target if at least kCorrection (m), but at most kCorrectionShare of it, is
/// taken back at once: before the tip rests along the shaft (less than kShaftRest, m, in kShaftRestTime,
/// s). A longer way back is a movement of its own. Advances that end at tissue do not count: coming
/// back from it is part of a touch.
inline constexpr double kCorrection = 0.003;
inline constexpr double kCorrectionShare = 0.5;
inline constexpr double kShaftRest = 0.001;
inline constexpr double kShaftRestTime = 0.3;

/// Measures the segments of one instrument. Each is smoothed separately; nothing is counted between
/// two segments.
MotionMetrics MeasureMotion(std::span<const TimeSeriesSegment> segments);

/// Returns the time in which both instruments are faster than kIdleSpeed, s.
double BothMoving(std::span<const TimeSeriesSegment> a, std::span<const TimeSeriesSegment> b);

using MotionInterval = std::pair<double, double>;  ///< From, to, s.

/// Returns the intervals in which an instrument is faster than kIdleSpeed, in order.
std::vector<MotionInterval> MovingIntervals(std::span<const TimeSeriesSegment> segments);

/// When a hand moves, and when it holds tissue in its jaws: in order, without overlaps.
struct HandWork {
  std::vector<MotionInterval> moves, holds;
};
/// Times of the hands' work, s. A hand works while it moves or holds tissue.
struct WorkTimes {
  double any_moves = 0;  ///< At least one hand moves.
  double together = 0;   ///< Of it: at least two hands work.
};
WorkTimes MeasureWork(std::span<const HandWork> hands);

/// Returns the spectral arc length (Balasubramanian et al. 2015) of one movement from its speeds,
/// sampled every `period` s. It is minus the arc length of the curve A(f) / A(0) over f / f_max,
/// with A the speed's amplitude spectrum. f_max is the highest frequency up to kSparcCutoff with
/// A(f) / A(0) >= kSparcAmplitude. Values closer to 0 are smoother. A minimum-jerk movement has
/// about -1.4 at every duration and size. Needs at least two speeds, not all 0.
double SpectralArcLength(std::span<const double> speeds, double period);
inline constexpr double kSparcCutoff = 10;       ///< Hz.
inline constexpr double kSparcAmplitude = 0.05;  ///< Fraction of the amplitude at 0.

}  // namespace hpdm
