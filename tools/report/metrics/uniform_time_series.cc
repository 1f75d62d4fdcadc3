#include "tools/report/metrics/uniform_time_series.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

namespace hpdm {
namespace {

/// y = b0 (x + 2 x' + x'') - a1 y' - a2 y'': the bilinear transform of a Butterworth low-pass.
class LowPass {
 public:
  LowPass(double cutoff, double period) {
    const double w = std::tan(std::numbers::pi * cutoff * period);
    const double scale = 1 / (1 + std::numbers::sqrt2 * w + w * w);
    b0_ = w * w * scale;
    a1_ = 2 * (w * w - 1) * scale;
    a2_ = (1 - std::numbers::sqrt2 * w + w * w) * scale;
  }
  void Rest(const MotionVector& value) { x1_ = x2_ = y1_ = y2_ = value; }
  MotionVector Next(const MotionVector& x) {
    const MotionVector y = b0_ * (x + 2 * x1_ + x2_) - a1_ * y1_ - a2_ * y2_;
    x2_ = std::exchange(x1_, x);
    y2_ = std::exchange(y1_, y);
    return y;
  }

 private:
  double b0_, a1_, a2_;
  MotionVector x1_, x2_, y1_, y2_;
};

}  // namespace

void UniformTimeSeries::Add(double time, const MotionVector& value) {
  if (joined_ && time - last_time_ > kMotionGap) Break();
  if (!joined_) {
    joined_ = true;
    segment_.start = time + kMotionPeriod / 2;  // a sample's time is the middle of its interval
    origin_ = time;
    sum_.setZero();
  } else if (time <= last_time_) {
    return;
  } else {
    const MotionVector slope = (value - last_) / (time - last_time_);
    double at = last_time_;
    while (at < time) {
      const double end = origin_ + static_cast<double>(segment_.samples.size() + 1) * kMotionPeriod;
      const double to = std::min(time, end);
      sum_ += (to - at) * (last_ + slope * ((at + to) / 2 - last_time_));
      at = to;
      if (to < end) break;
      segment_.samples.push_back(sum_ / kMotionPeriod);
      sum_.setZero();
    }
  }
  last_time_ = time;
  last_ = value;
}

void UniformTimeSeries::Break() {
  if (!segment_.samples.empty()) segments_.push_back(std::move(segment_));
  segment_ = {};
  joined_ = false;
}

void SmoothZeroPhase(double cutoff, double period, std::vector<MotionVector>* samples) {
  const std::size_t count = samples->size();
  if (count < 2) return;
  // Two passes attenuate by 3 dB at `cutoff` if each pass attenuates by 3 dB at this frequency.
  const double each = cutoff / std::pow(std::numbers::sqrt2 - 1, 0.25);
  // The transient of a start at rest decays within about one period of the cut-off frequency.
  const auto lead = std::min(count - 1, static_cast<std::size_t>(std::ceil(2 / (cutoff * period))));
  std::vector<MotionVector> series;
  series.reserve(count + 2 * lead);
  for (std::size_t i = lead; i > 0; --i) {
    series.push_back(2 * samples->front() - (*samples)[i]);
  }
  series.insert(series.end(), samples->begin(), samples->end());
  for (std::size_t i = 1; i <= lead; ++i) {
    series.push_back(2 * samples->back() - (*samples)[count - 1 - i]);
  }
  LowPass filter(each, period);
  filter.Rest(series.front());
  for (MotionVector& value : series) value = filter.Next(value);
  filter.Rest(series.back());
  for (std::size_t i = series.size(); i-- > 0;) series[i] = filter.Next(series[i]);
  std::copy_n(series.begin() + static_cast<std::ptrdiff_t>(lead), count, samples->begin());
}

}  // namespace hpdm
