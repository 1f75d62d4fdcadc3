#pragma once

#include <span>
#include <string>

#include "tools/report/metrics/session_metrics.h"

namespace hpdm {

/// Which of two values of a figure is better, if the task was the same.
enum class Better { kNeither, kLower, kHigher };

/// Describes one figure of a hand for people. tools/report/README.md has the full definitions.
struct MetricDefinition {
  const char* key;      ///< Key in ToJson's hand.
  const char* label;    ///< Name for people.
  const char* unit;     ///< Displayed unit; empty for plain numbers.
  double scale;         ///< Displayed value / JSON value.
  const char* format;   ///< printf format of the displayed value.
  const char* meaning;  ///< One or two sentences; may contain "%LIMIT%" (force) or
                        ///< "%DEPTH_LIMIT%".
  const char* source;   ///< Keys of MetricSources(), separated by "; "; empty: our own definition.
  Better better;        ///< As the source says, or the published differences of experts.
};

/// Returns the figures in the order of display.
std::span<const MetricDefinition> MetricDefinitions();

/// Finds a figure by its key in ToJson's hand; null if there is none.
const MetricDefinition* FindMetric(const std::string& key);

/// A publication on which a definition is based.
struct MetricSource {
  const char* key;
  const char* text;
};
std::span<const MetricSource> MetricSources();

}  // namespace hpdm
