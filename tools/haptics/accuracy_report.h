#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/haptics/accuracy_cases.h"
#include "tools/haptics/force_accuracy.h"
#include "tools/haptics/tip_accuracy.h"

namespace hpdm {

inline constexpr double kErrorTarget = 0.05;  ///< ContactError, at most.
inline constexpr double kErrorAim = 0.02;
inline constexpr double kCombTarget = 0.01;  ///< Comb, at most.

/// One instrument of one case.
struct HandReport {
  std::string case_name;
  ForceResults results;
  std::string series;  ///< File name of TimeSeriesTable.
};

/// CSV of one instrument: `t` (s), |force| in N `production_N`, `reference_N`, `reference_tick_N`,
/// `paper_N`, `paper_fitted_N`, the two that are compared by component (`production_x` ... `_z`,
/// `reference_x` ... `_z`), and `depth` (m).
std::string TimeSeriesTable(const ForceTimeSeries& series, double rate_hz);

/// { "targets": {...}, "hands": [...], "tips": [...] }; keys carry their unit, errors are shares.
nlohmann::ordered_json AccuracyJson(const std::vector<HandReport>& hands,
                                    const std::vector<TipAccuracy>& tips);

/// For a terminal: the table's head, a row each, and the tips.
std::string AccuracyHead();
std::string AccuracyRow(const HandReport& hand);
std::string AccuracyTips(const std::vector<TipAccuracy>& tips);

/// The same figures as tables of Markdown.
std::string AccuracyMarkdown(const std::vector<HandReport>& hands,
                             const std::vector<TipAccuracy>& tips);

}  // namespace hpdm
