#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/stress/stress_case.h"

namespace hpdm {

/// A case and where the models stand in it.
struct StressRow {
  StressCase stress_case;
  std::vector<StressResult> results;
};

/// Stable: scripts read it. {name, group, title, truth, parameter, results}.
nlohmann::ordered_json ToJson(const StressRow& row);

/// A line a case and model, for plots: case, group, title, parameter, unit, easy, asked, utmost,
/// model, fate, error, how, holds_to, fails_from, fails_how, harm, trials.
std::string StressCsv(const std::vector<StressRow>& rows);

/// A table for people: a row a case, a column a model that any case was run on.
std::string StressMarkdown(const std::vector<StressRow>& rows);

/// The same for a terminal: a line a case and model.
std::string StressText(const StressRow& row);

/// Every harm done to a model of ours, one line each: there must be none.
std::vector<std::string> Harms(const std::vector<StressRow>& rows);

}  // namespace hpdm
