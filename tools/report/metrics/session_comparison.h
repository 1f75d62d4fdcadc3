#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tools/report/metrics/metric_definitions.h"
#include "tools/report/metrics/session_metrics.h"

namespace hpdm {

/// Lengths that differ by more than this share of the longer one are reported.
inline constexpr double kSameLength = 0.1;

/// Returns short names of two sessions that differ: the last parts of the paths of their folders
/// (or of bare logs), as few as necessary.
std::pair<std::string, std::string> SessionNames(const SessionReport& a, const SessionReport& b);

/// Tells whether two sessions had the same task, as far as their logs show it.
struct TaskComparison {
  bool same_scene = true;             ///< Neither the scene's name nor the organs differ.
  bool same_instruments = true;       ///< Each hand began with the same one at the same port.
  bool both_touch = true;             ///< Either both had contact with tissue, or none had.
  bool same_length = true;            ///< Within kSameLength, without pauses and gaps.
  std::vector<std::string> warnings;  ///< One line for each difference; plain, not HTML.

  /// True if a lower or higher figure may be called better.
  bool MayJudge() const { return same_scene && same_instruments && both_touch; }
};
TaskComparison CompareTasks(const SessionReport& report, const SessionReport& against);

/// Difference of one figure between two sessions, in the displayed unit and precision.
struct MetricDifference {
  enum Verdict { kUnjudged, kSame, kBetter, kWorse };
  std::optional<double> value;  ///< Displayed value now minus displayed value before.
  Verdict verdict = kUnjudged;  ///< kSame if the displayed values are equal.
};

/// Compares a figure of two hands. `now` and `before` are numbers of ToJson's hands, or null.
MetricDifference CompareMetric(const MetricDefinition& metric, const nlohmann::ordered_json& now,
                               const nlohmann::ordered_json& before, bool may_judge);

/// Formats a value in the figure's displayed unit and precision, without the unit.
std::string MetricText(const MetricDefinition& metric, double displayed);

/// Returns the hand of the same name in another session, or else the one in the same place; null if
/// there is none. `report`: ToJson of that session.
const nlohmann::ordered_json* SameHand(const nlohmann::ordered_json& report,
                                       const nlohmann::ordered_json& name, std::size_t index);

/// Returns the comparison for `hpdm report --json`: "sessions", "warnings" and, for each hand, the
/// differences of its figures in SI units, each with "better", "worse", "same" or null.
nlohmann::ordered_json ComparisonToJson(const SessionReport& report, const SessionReport& against);

}  // namespace hpdm
