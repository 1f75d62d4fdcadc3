#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace hpdm {

/// The fit y = plateau - drop / n to the n-th sessions' values, by least squares (Feldman et al. 2009:
/// "learning plateau" and "learning rate").
struct LearningFit {
  double plateau = 0;
  double drop = 0;
  double explained = 0;  ///< Share of the variance, R^2; 0..1.
  /// Number of sessions until 90 % of the plateau; only of a rise to a plateau above 0.
  std::optional<double> sessions_to_90;
};

/// Fewest values for a fit.
inline constexpr std::size_t kFewestForFit = 5;

/// Fits values in the order of the sessions. Missing ones have nothing. Returns nothing with fewer
/// than kFewestForFit values, or if all are equal.
std::optional<LearningFit> FitLearning(std::span<const std::optional<double>> values);

/// One figure over the sessions of a task.
struct LearningSeries {
  std::string key, label, unit;
  std::vector<std::optional<double>> values;  ///< By session, as displayed.
  std::optional<LearningFit> fit;             ///< Only of figures that rise with learning.
};

/// The sessions of one task, in the order of their starts.
struct LearningCurve {
  std::string task;                ///< The exercise's name, or else the scene's.
  std::vector<std::string> names;  ///< Of the sessions.
  std::vector<std::string> starts;
  std::vector<LearningSeries> series;  ///< Those with a value.
};

/// Groups lines of sessions (session_line.h) by task. Sessions with a failure or without a scene's name
/// are left out. A session without a wall clock stands where its log was written. The tasks are in the
/// order of their names.
std::vector<LearningCurve> LearningCurves(std::span<const nlohmann::ordered_json> lines);

}  // namespace hpdm
