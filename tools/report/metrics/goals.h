#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tools/report/metrics/session_metrics.h"

namespace hpdm {

/// How one figure is mapped to a rating: `worst` gives 1, `best` 5, linearly between, and no less or
/// more beyond. All thresholds are guesses of this project: no study has tied them to observers.
struct GoalsScale {
  const char* key;    ///< In ToJson; SI units.
  const char* label;  ///< For people.
  const char* unit;   ///< Displayed unit; empty for plain numbers.
  double scale;       ///< Displayed value / value.
  double worst, best;
};

/// A figure of a session and its rating.
struct GoalsPart {
  const char* key;
  const GoalsScale* scale = nullptr;
  double value = 0;
  double rating = 0;  ///< 1..5.
};

/// A domain of GOALS (Vassiliou et al. 2005), estimated from a session's figures.
struct GoalsDomain {
  const char* key;    ///< "depth_perception".
  const char* label;  ///< "Depth perception".
  const char* rule;   ///< How the domain follows from its figures, for people.
  std::vector<GoalsPart> parts = {};
  std::optional<double> rating = {};  ///< 1..5, in tenths as it is displayed.
  std::string why_not = {};           ///< Why there is no rating, for people.
};

/// Fewest advances for a rating of depth perception.
inline constexpr std::uint64_t kFewestAdvances = 5;
/// Shortest contact for a rating of tissue handling, s.
inline constexpr double kLeastContact = 1;

/// Rates a session: depth perception, bimanual dexterity, efficiency, tissue handling, in this order,
/// and autonomy, which never has a rating. tools/report/README.md has the mapping.
std::vector<GoalsDomain> RateGoals(const SessionReport& report);

/// The scales of all figures, for documentation.
std::span<const GoalsScale> GoalsScales();

}  // namespace hpdm
