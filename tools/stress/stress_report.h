#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/stress/stress_case.h"

namespace hpdm {

/// A case and the results of the models in it.
struct StressRow {
  StressCase stress_case;
  std::vector<StressResult> results;
};

/// Returns {name, group, title, truth, parameter, results}. Stable: scripts read it.
nlohmann::ordered_json ToJson(const StressRow& row);

/// Returns a line per case and model, for plots: case, group, title, parameter, unit, easy, asked,
/// utmost, model, fate, error, how, holds_to, fails_from, fails_how, harm, trials.
std::string StressCsv(const std::vector<StressRow>& rows);

/// Returns a Markdown table: a row per case, a column per model that any case was run on.
std::string StressMarkdown(const std::vector<StressRow>& rows);

/// Returns the same for a terminal: a line per case and model.
std::string StressText(const StressRow& row);

/// Returns every harm done to one of our models, one line each. There must be none.
std::vector<std::string> Harms(const std::vector<StressRow>& rows);

}  // namespace hpdm
