#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/plan/scene_plan.h"

namespace hpdm {

/// Each organ's models from fast to slow with estimate and cost: '*' where none beats it in both,
/// '>' where it was chosen.
std::string PlanText(const ScenePlan& plan);

/// Whether both demands are met, and if not which cannot be and by how much: lines, each with its
/// end.
std::string VerdictText(const ScenePlan& plan);

/// The same as a table for the README, the Pareto fronts alone.
std::string PlanMarkdown(const ScenePlan& plan, const std::string& scene,
                         const std::string& machine);

nlohmann::ordered_json ToJson(const ScenePlan& plan);

/// Rows of all points for the plot: `header` lines after '#', the names, a row a point.
std::string PlanCsv(const ScenePlan& plan, const std::vector<std::string>& header);

}  // namespace hpdm
