#pragma once

#include <span>
#include <string>

#include "tools/report/metrics/session_metrics.h"

namespace hpdm {

/// One figure of a hand: how people read it. In full, with symbols: tools/report/README.md.
struct MetricDefinition {
  const char* key;      ///< Of ToJson's hand.
  const char* label;    ///< For people.
  const char* unit;     ///< Shown; empty for numbers.
  double scale;         ///< Shown value / JSON value.
  const char* format;   ///< printf's, of the shown value.
  const char* meaning;  ///< One or two sentences; may hold "%LIMIT%".
  const char* source;   ///< Keys of Sources(), separated by "; "; empty: our own.
};

/// In the order they are shown.
std::span<const MetricDefinition> MetricDefinitions();
/// By a key of ToJson's hand; null when it is no figure.
const MetricDefinition* FindMetric(const std::string& key);

/// A publication that a definition follows.
struct MetricSource {
  const char* key;
  const char* text;
};
std::span<const MetricSource> MetricSources();

}  // namespace hpdm
