#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tools/report/metrics/uniform_time_series.h"

namespace hpdm {

/// How one instrument moved. Definitions, filters and sources: tools/report/README.md.
struct MotionMetrics {
  double time = 0;            ///< s, that the samples stand for.
  double path_length = 0;     ///< m, of the tip.
  double angular_path = 0;    ///< rad, of the shaft about the trocar.
  double roll_path = 0;       ///< rad, about the shaft.
  double insertion_path = 0;  ///< m, along the shaft ("depth").
  double mean_speed = 0;      ///< m/s, path_length / time.
  double peak_speed = 0;      ///< m/s.
  double idle = 0;            ///< s, slower than kIdleSpeed.
  std::uint64_t movements = 0;
  std::optional<double> economy;     ///< 0..1: distance over path, of the movements; absent: none.
  std::optional<double> smoothness;  ///< SPARC, median of the movements up to kDiscreteMovement.
  double mean_force_rate = 0;        ///< N/s, mean |dF/dt| while there is a force.
  double peak_force_rate = 0;        ///< N/s.
};

/// Cut-off of the smoothing, Hz.
inline constexpr double kMotionCutoff = 10;
/// A tip slower than this is idle, m/s.
inline constexpr double kIdleSpeed = 0.005;
/// A movement is faster than kIdleSpeed for at least so long, s, and at its fastest faster than
/// kMovementSpeed, m/s.
inline constexpr double kMovementTime = 0.1;
inline constexpr double kMovementSpeed = 0.01;
/// For its smoothness a movement is followed beyond kIdleSpeed, outwards to this part of its
/// fastest speed, or to where it is slowest.
inline constexpr double kMovementEdge = 0.01;
/// Longer ones, s, are no discrete movements, for which alone SPARC is defined.
inline constexpr double kDiscreteMovement = 10;
/// Forces below this are none, N: far below what the hand can tell.
inline constexpr double kNoForce = 0.01;

/// An instrument's segments, each smoothed on its own; nothing is counted between two of them.
MotionMetrics MeasureMotion(std::span<const TimeSeriesSegment> segments);

/// Time that both are faster than kIdleSpeed, s.
double BothMoving(std::span<const TimeSeriesSegment> a, std::span<const TimeSeriesSegment> b);

/// Spectral arc length of one movement's speeds, one every `period` s (Balasubramanian et al.
/// 2015): minus the length of the curve of the speed's amplitude spectrum, normalised by its value
/// at 0, over frequency, normalised by the highest up to kSparcCutoff at which it still reaches
/// kSparcAmplitude. Closer to 0 is smoother; a minimum-jerk movement has about -1.4, whatever its
/// length and size. At least two speeds that are not all 0.
double SpectralArcLength(std::span<const double> speeds, double period);
inline constexpr double kSparcCutoff = 10;       ///< Hz.
inline constexpr double kSparcAmplitude = 0.05;  ///< Of the amplitude at 0.

}  // namespace hpdm
