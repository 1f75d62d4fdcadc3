#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "engine/threads/histogram.h"

namespace hpdm {

/// Returns the indented JSON of a command's report. Bytes that are not UTF-8, as paths may have,
/// become replacement characters.
inline std::string JsonText(const nlohmann::ordered_json& json) {
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

/// Returns mean, p50, p90, p99, p99.9 and max of durations, us, and their number.
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
