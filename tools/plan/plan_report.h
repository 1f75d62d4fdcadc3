#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/plan/scene_plan.h"

namespace hpdm {

/// Returns each organ's models from fast to slow with error estimate and cost. '*' marks those that
/// none beats in both, '>' the chosen one.
std::string PlanText(const ScenePlan& plan);

/// Returns lines that state whether both demands are met, and if not, which fails and by how much.
std::string VerdictText(const ScenePlan& plan);

/// Returns the same as a table for the README, with only the Pareto fronts.
std::string PlanMarkdown(const ScenePlan& plan, const std::string& scene,
                         const std::string& machine);

nlohmann::ordered_json ToJson(const ScenePlan& plan);

/// Returns rows of all points for the plot: `header` lines after '#', the names, one row per point.
std::string PlanCsv(const ScenePlan& plan, const std::vector<std::string>& header);

}  // namespace hpdm
