#include "tools/report/metrics/motion_metrics.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

namespace hpdm {
namespace {

/// Returns the direction of the shaft in the gimbal's home frame (haptics/device/impulse_engine.h).
/// Angles between directions do not depend on the frame.
Vector3d Direction(const MotionVector& v) {
  const double pitch = v[kMotionPitch], yaw = v[kMotionYaw];
  return {std::cos(pitch) * std::sin(yaw), -std::sin(pitch), std::cos(pitch) * std::cos(yaw)};
}

double AngleBetween(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

Vector3d Tip(const MotionVector& v) { return v.segment<3>(kMotionTip); }
Vector3d Force(const MotionVector& v) { return v.segment<3>(kMotionForce); }

/// Returns |dr/dt| by central differences, one-sided at the ends; zeros for a single sample.
template <typename Part>
std::vector<double> Rates(const std::vector<MotionVector>& samples, Part part) {
  std::vector<double> rates(samples.size(), 0.0);
  if (samples.size() < 2) return rates;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const std::size_t before = i > 0 ? i - 1 : 0, after = std::min(i + 1, samples.size() - 1);
    rates[i] = (part(samples[after]) - part(samples[before])).norm() /
               (static_cast<double>(after - before) * kMotionPeriod);
  }
  return rates;
}

struct Sums {
  double distance = 0, path = 0;      // over the movements, m
  std::vector<double> smoothness;     // of each movement
  double force_rate = 0;              // sum over the samples with a force, N/s
  std::size_t moved = 0, forced = 0;  // numbers of samples
};

/// Extends the movement [begin, end) outwards while it slows down, to kMovementEdge of its peak
/// speed. Cut at kIdleSpeed, its speeds would have a step at each end, which changes the spectrum.
std::pair<std::size_t, std::size_t> Whole(const std::vector<double>& speeds, std::size_t begin,
                                          std::size_t end) {
  const auto at = [&speeds](std::size_t i) {
    return speeds.begin() + static_cast<std::ptrdiff_t>(i);
  };
  const double edge = kMovementEdge * *std::max_element(at(begin), at(end));
  while (begin > 0 && speeds[begin] > edge && speeds[begin - 1] < speeds[begin]) --begin;
  while (end < speeds.size() && speeds[end - 1] > edge && speeds[end] < speeds[end - 1]) ++end;
  return {begin, end};
}

/// Adds the samples [begin, end), all faster than kIdleSpeed, if they are a movement.
void AddMovement(const std::vector<MotionVector>& samples, const std::vector<double>& speeds,
                 std::size_t begin, std::size_t end, MotionMetrics* metrics, Sums* sums) {
  if (static_cast<double>(end - begin) * kMotionPeriod < kMovementTime) return;
  const auto first = speeds.begin() + static_cast<std::ptrdiff_t>(begin);
  const auto last = speeds.begin() + static_cast<std::ptrdiff_t>(end);
  if (*std::max_element(first, last) < kMovementSpeed) return;
  ++metrics->movements;
  sums->distance += (Tip(samples[end - 1]) - Tip(samples[begin])).norm();
  for (std::size_t i = begin + 1; i < end; ++i) {
    sums->path += (Tip(samples[i]) - Tip(samples[i - 1])).norm();
  }
  if (static_cast<double>(end - begin) * kMotionPeriod <= kDiscreteMovement) {
    const auto [from, to] = Whole(speeds, begin, end);
    sums->smoothness.push_back(
        SpectralArcLength(std::span(speeds).subspan(from, to - from), kMotionPeriod));
  }
}

void Measure(const std::vector<MotionVector>& samples, MotionMetrics* metrics, Sums* sums) {
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const MotionVector &a = samples[i - 1], &b = samples[i];
    metrics->path_length += (Tip(b) - Tip(a)).norm();
    metrics->angular_path += AngleBetween(Direction(a), Direction(b));
    metrics->roll_path += std::abs(b[kMotionRoll] - a[kMotionRoll]);
    metrics->insertion_path += std::abs(b[kMotionInsertion] - a[kMotionInsertion]);
  }
  const std::vector<double> speeds = Rates(samples, Tip);
  std::size_t begin = 0;
  for (std::size_t i = 0; i <= speeds.size(); ++i) {
    const bool moves = i < speeds.size() && speeds[i] >= kIdleSpeed;
    if (moves) ++sums->moved;
    if (moves) continue;
    AddMovement(samples, speeds, begin, i, metrics, sums);
    begin = i + 1;
  }
  for (const double speed : speeds) metrics->peak_speed = std::max(metrics->peak_speed, speed);
  const std::vector<double> force_rates = Rates(samples, Force);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    metrics->peak_force_rate = std::max(metrics->peak_force_rate, force_rates[i]);
    if (Force(samples[i]).norm() < kNoForce) continue;
    ++sums->forced;
    sums->force_rate += force_rates[i];
  }
}

/// Counts advances along the shaft, and those that overshot (motion_metrics.h). The insertion goes in
/// legs, in and out in turn. A leg ends where it turns by kCorrection, or rests.
class AdvanceCounter {
 public:
  explicit AdvanceCounter(MotionMetrics* metrics) : metrics_(*metrics) {}

  void Count(const std::vector<MotionVector>& samples) {
    if (samples.empty()) return;
    turn_ = extreme_ = rest_ = samples.front()[kMotionInsertion];
    std::size_t resting_since = 0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double at = samples[i][kMotionInsertion];
      if (std::abs(at - rest_) >= kShaftRest) {
        rest_ = at;
        resting_since = i;
      } else if (static_cast<double>(i - resting_since) * kMotionPeriod >= kShaftRestTime) {
        if (direction_ != 0) EndLeg();
        turn_ = extreme_ = at;
        direction_ = 0;
        free_advance_ = 0;
        continue;
      }
      Follow(at, Force(samples[i]).norm() >= kNoForce);
    }
    if (direction_ != 0) EndLeg();
  }

 private:
  void Follow(double at, bool touches) {
    if (direction_ == 0) {
      if (std::abs(at - turn_) < kCorrection) return;
      direction_ = at > turn_ ? 1 : -1;
      extreme_ = at;
      touches_ = touches;
    } else if (direction_ * (at - extreme_) >= 0) {
      extreme_ = at;
      touches_ = touches;
    } else if (direction_ * (extreme_ - at) >= kCorrection) {
      EndLeg();
      turn_ = extreme_;
      extreme_ = at;
      touches_ = touches;
      direction_ = -direction_;
    }
  }
  void EndLeg() {
    const double leg = extreme_ - turn_;
    if (leg >= kAdvance) ++metrics_.advances;
    if (-leg >= kCorrection && -leg <= kCorrectionShare * free_advance_) ++metrics_.overshoots;
    free_advance_ = leg >= kAdvance && !touches_ ? leg : 0;
  }

  MotionMetrics& metrics_;
  double turn_ = 0, extreme_ = 0;  // of the present leg: where it began, and its farthest place, m
  bool touches_ = false;           // there is a force at `extreme_`
  int direction_ = 0;              // 1 in, -1 out, 0 none yet
  double rest_ = 0;                // m, where the insertion last changed by kShaftRest
  double free_advance_ = 0;        // m, the leg before if it was an advance that touched nothing
};

std::vector<MotionVector> Smoothed(const TimeSeriesSegment& segment) {
  std::vector<MotionVector> samples = segment.samples;
  SmoothZeroPhase(kMotionCutoff, kMotionPeriod, &samples);
  return samples;
}

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return (*middle + *std::max_element(values.begin(), middle)) / 2;
}

}  // namespace

double SpectralArcLength(std::span<const double> speeds, double period) {
  // Samples the spectrum as the authors do: zero padding to 2^4 times the next power of two.
  std::size_t padded = 1;
  while (padded < speeds.size()) padded *= 2;
  padded *= 16;
  const double step = 1 / (static_cast<double>(padded) * period);  // Hz
  const auto bins = static_cast<std::size_t>(kSparcCutoff / step) + 1;
  std::vector<double> amplitudes;
  amplitudes.reserve(bins);
  for (std::size_t k = 0; k < bins; ++k) {
    // Goertzel's recurrence: the few bins of a short movement need no fast transform.
    const double w = 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(padded);
    const double twice = 2 * std::cos(w);
    double s1 = 0, s2 = 0;
    for (const double speed : speeds) {
      const double s = speed + twice * s1 - s2;
      s2 = s1;
      s1 = s;
    }
    amplitudes.push_back(std::sqrt(std::max(0.0, s1 * s1 + s2 * s2 - twice * s1 * s2)));
  }
  std::size_t last = 0;
  for (std::size_t k = 0; k < bins; ++k) {
    if (amplitudes[k] >= kSparcAmplitude * amplitudes[0]) last = k;
  }
  double length = 0;
  for (std::size_t k = 1; k <= last; ++k) {
    length += std::hypot(1 / static_cast<double>(last),
                         (amplitudes[k] - amplitudes[k - 1]) / amplitudes[0]);
  }
  return -length;
}

MotionMetrics MeasureMotion(std::span<const TimeSeriesSegment> segments) {
  MotionMetrics metrics;
  Sums sums;
  std::size_t count = 0;
  for (const TimeSeriesSegment& segment : segments) {
    const std::vector<MotionVector> samples = Smoothed(segment);
    Measure(samples, &metrics, &sums);
    AdvanceCounter(&metrics).Count(samples);
    count += segment.samples.size();
  }
  const auto seconds = [](std::size_t samples) {
    return static_cast<double>(samples) * kMotionPeriod;
  };
  metrics.time = seconds(count);
  metrics.idle = seconds(count - sums.moved);
  if (count > 0) metrics.mean_speed = metrics.path_length / metrics.time;
  if (sums.path > 0) metrics.economy = sums.distance / sums.path;
  if (!sums.smoothness.empty()) metrics.smoothness = Median(std::move(sums.smoothness));
  if (sums.forced > 0) metrics.mean_force_rate = sums.force_rate / static_cast<double>(sums.forced);
  return metrics;
}

std::vector<MotionInterval> MovingIntervals(std::span<const TimeSeriesSegment> segments) {
  std::vector<MotionInterval> moving;
  for (const TimeSeriesSegment& segment : segments) {
    const std::vector<double> speeds = Rates(Smoothed(segment), Tip);
    bool moves = false;
    for (std::size_t i = 0; i < speeds.size(); ++i) {
      const double from = segment.start + (static_cast<double>(i) - 0.5) * kMotionPeriod;
      const bool moved = std::exchange(moves, speeds[i] >= kIdleSpeed);
      if (moves && !moved) moving.emplace_back(from, from);
      if (moves) moving.back().second = from + kMotionPeriod;
    }
  }
  return moving;
}

double BothMoving(std::span<const TimeSeriesSegment> a, std::span<const TimeSeriesSegment> b) {
  const std::vector<MotionInterval> left = MovingIntervals(a), right = MovingIntervals(b);
  double both = 0;
  for (std::size_t l = 0, r = 0; l < left.size() && r < right.size();) {
    both += std::max(
        0.0, std::min(left[l].second, right[r].second) - std::max(left[l].first, right[r].first));
    left[l].second < right[r].second ? ++l : ++r;
  }
  return both;
}

WorkTimes MeasureWork(std::span<const HandWork> hands) {
  // A change of one hand's state at a time.
  struct Change {
    double time;
    std::size_t hand;
    int moves, holds;  // +1 begins, -1 ends
  };
  std::vector<Change> changes;
  for (std::size_t h = 0; h < hands.size(); ++h) {
    for (const auto& [from, to] : hands[h].moves) {
      changes.push_back({from, h, 1, 0});
      changes.push_back({to, h, -1, 0});
    }
    for (const auto& [from, to] : hands[h].holds) {
      changes.push_back({from, h, 0, 1});
      changes.push_back({to, h, 0, -1});
    }
  }
  std::ranges::sort(changes, {}, &Change::time);
  std::vector<int> moves(hands.size(), 0), holds(hands.size(), 0);
  WorkTimes times;
  double last = 0;
  for (const Change& change : changes) {
    std::size_t moving = 0, working = 0;
    for (std::size_t h = 0; h < hands.size(); ++h) {
      moving += moves[h] > 0;
      working += moves[h] > 0 || holds[h] > 0;
    }
    const double passed = change.time - last;
    if (moving > 0) times.any_moves += passed;
    if (moving > 0 && working > 1) times.together += passed;
    last = change.time;
    moves[change.hand] += change.moves;
    holds[change.hand] += change.holds;
  }
  return times;
}

}  // namespace hpdm
