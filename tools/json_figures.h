#pragma once

#include <nlohmann/json.hpp>

#include "engine/histogram.h"

namespace hpdm {

/// Percentiles of durations, in microseconds: mean, p50, p90, p99, p99.9, max, and their number.
inline nlohmann::ordered_json ToJson(const Histogram& histogram) {
  const auto us = [](double ns) { return ns / 1000; };
  return {{"count", histogram.count()},
          {"mean_us", us(histogram.mean())},
          {"p50_us", us(static_cast<double>(histogram.Percentile(0.5)))},
          {"p90_us", us(static_cast<double>(histogram.Percentile(0.9)))},
          {"p99_us", us(static_cast<double>(histogram.Percentile(0.99)))},
          {"p99_9_us", us(static_cast<double>(histogram.Percentile(0.999)))},
          {"max_us", us(static_cast<double>(histogram.max()))}};
}

}  // namespace hpdm
