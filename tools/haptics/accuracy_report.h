#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/haptics/accuracy_cases.h"
#include "tools/haptics/force_accuracy.h"
#include "tools/haptics/tip_accuracy.h"

namespace hpdm {

inline constexpr double kPressTarget = 0.02;  ///< Largest allowed independent_error without jaws.
inline constexpr double kGraspTarget = 0.05;  ///< The same of a hand that grasps.
inline constexpr double kCombTarget = 0.01;   ///< Largest allowed Comb.

/// Results of one instrument in one case.
struct HandAccuracy {
  std::string case_name;
  ForceResults results;
  std::string series;  ///< File name of TimeSeriesTable.

  /// Largest allowed independent_error.
  double Target() const;
};

/// Returns the CSV of one instrument: `t` (s), |force| in N (`production_N`, `reference_N`,
/// `reference_tick_N`, `paper_N`, `paper_fitted_N`, `independent_N`, which is empty in ticks that are
/// not judged), the components of the two compared forces
/// (`production_x` ... `_z`, `reference_x` ... `_z`) and `depth` (m).
std::string TimeSeriesTable(const ForceTimeSeries& series, double rate_hz);

/// Returns { "targets": {...}, "hands": [...], "tips": [...] }. Keys carry their unit; errors are
/// fractions.
nlohmann::ordered_json AccuracyJson(const std::vector<HandAccuracy>& hands,
                                    const std::vector<TipAccuracy>& tips);

/// Returns text for a terminal: the table's head, one row each, and the tips.
std::string AccuracyHead();
std::string AccuracyRow(const HandAccuracy& hand);
std::string AccuracyTips(const std::vector<TipAccuracy>& tips);

/// Returns the same results as Markdown tables.
std::string AccuracyMarkdown(const std::vector<HandAccuracy>& hands,
                             const std::vector<TipAccuracy>& tips);

}  // namespace hpdm
