#include "tools/shared/force_signal.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <utility>

#include "engine/base/check.h"

namespace hpdm {
namespace {

constexpr double kSegmentPeriods = 10;
constexpr double kMinPeriods = 4;

using Segment = std::pair<std::size_t, std::size_t>;  // [first, end)

// Cuts the periods of contact (force not zero) into Welch segments.
std::vector<Segment> ContactSegments(const ForceSignal& force, double period) {
  const auto longest = static_cast<std::size_t>(std::lround(kSegmentPeriods * period));
  const auto least = static_cast<std::size_t>(std::lround(kMinPeriods * period));
  std::vector<Segment> segments;
  for (std::size_t first = 0, end = 0; first < force.size(); first = end + 1) {
    end = first;
    while (end < force.size() && force[end].squaredNorm() > 0) ++end;
    if (end - first < least) continue;
    if (end - first <= longest) {
      segments.emplace_back(first, end);
      continue;
    }
    for (std::size_t at = first; at + longest <= end; at += longest / 2) {
      segments.emplace_back(at, at + longest);
    }
  }
  return segments;
}

std::vector<double> HannWindow(std::size_t length) {
  std::vector<double> window(length);
  for (std::size_t t = 0; t < length; ++t) {
    const double phase = 2 * std::numbers::pi * (static_cast<double>(t) + 0.5);
    window[t] = 0.5 - 0.5 * std::cos(phase / static_cast<double>(length));
  }
  return window;
}

// Returns the power of the sinusoid of `cycles` a sample, N^2, summed over the axes.
double PowerAt(double cycles, const ForceSignal& force, const Segment& segment,
               const std::vector<double>& window) {
  Eigen::Vector3cd sum = Eigen::Vector3cd::Zero();
  double total = 0;
  for (std::size_t t = 0; t < window.size(); ++t) {
    const double angle = -2 * std::numbers::pi * cycles * static_cast<double>(t);
    sum += window[t] * std::polar(1.0, angle) * force[segment.first + t];
    total += window[t];
  }
  return 2 * sum.squaredNorm() / (total * total);
}

double Power(const ForceSignal& force, const Segment& segment, const std::vector<double>& window) {
  double sum = 0, total = 0;
  for (std::size_t t = 0; t < window.size(); ++t) {
    sum += window[t] * window[t] * force[segment.first + t].squaredNorm();
    total += window[t] * window[t];
  }
  return sum / total;
}

}  // namespace

double PeakForce(const ForceSignal& force) {
  double peak = 0;
  for (const Vector3d& f : force) peak = std::max(peak, f.norm());
  return peak;
}

double ContactError(const ForceSignal& force, const ForceSignal& reference) {
  HPDM_CHECK(force.size() == reference.size());
  double sum = 0;
  int count = 0;
  for (std::size_t t = 0; t < force.size(); ++t) {
    if (force[t].squaredNorm() == 0 && reference[t].squaredNorm() == 0) continue;
    sum += (force[t] - reference[t]).squaredNorm();
    ++count;
  }
  return count == 0 ? 0 : std::sqrt(sum / count) / PeakForce(reference);
}

double LargestStep(const ForceSignal& force) {
  double largest = 0;
  for (std::size_t t = 1; t < force.size(); ++t) {
    largest = std::max(largest, (force[t] - force[t - 1]).norm());
  }
  return largest;
}

double Comb(const ForceSignal& force, const ForceSignal& reference, double rate_hz,
            double comb_hz) {
  HPDM_CHECK(force.size() == reference.size());
  const std::vector<Segment> segments = ContactSegments(reference, rate_hz / comb_hz);
  if (segments.empty()) return std::numeric_limits<double>::quiet_NaN();
  double power = 0;
  std::vector<double> beyond(static_cast<std::size_t>(rate_hz / 2 / comb_hz), 0.0);
  for (const Segment& segment : segments) {
    const std::vector<double> window = HannWindow(segment.second - segment.first);
    power += Power(force, segment, window);
    for (std::size_t i = 0; i < beyond.size(); ++i) {
      const double cycles = static_cast<double>(i + 1) * comb_hz / rate_hz;
      beyond[i] +=
          PowerAt(cycles, force, segment, window) - PowerAt(cycles, reference, segment, window);
    }
  }
  double comb = 0;
  for (const double b : beyond) comb += std::max(b, 0.0);
  return std::sqrt(comb / power);
}

}  // namespace hpdm
