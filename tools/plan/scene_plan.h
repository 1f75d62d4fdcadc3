#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tools/plan/organ_search.h"

namespace hpdm {

/// Demands on a scene's models.
struct PlanDemand {
  double error = 0;      ///< Relative L2 error of the surface motion, for each organ that is
                         ///< touched.
  double budget_us = 0;  ///< Deformation step of all organs that can be touched at once.
};

/// Result of a plan for one organ.
enum class OrganFate {
  kSearched,  ///< Touched: a model is chosen.
  kRigid,     ///< Out of reach: it becomes rigid.
  kAsItIs,    ///< Rigid already, or out of reach with a mesh that cannot be rigid.
};

struct OrganPlan {
  std::string name;
  OrganFate fate = OrganFate::kAsItIs;
  bool hollow = false;
  OrganTouches touches;
  ReferenceSolution reference_solution;
  std::vector<PlanPoint> points;
};

/// A model for each organ (none if not searched), their total cost and the largest error.
struct PlanChoice {
  std::vector<std::optional<std::size_t>> points;
  double step_us = 0;
  double error = 0;
};

struct ScenePlan {
  PlanDemand demand;
  std::vector<OrganPlan> organs;
  /// The cheapest models of at most the demanded error, whatever they cost. None if an organ has no
  /// such model among those searched, or if its reference solution cannot judge that error.
  std::optional<PlanChoice> of_error;
  /// The most accurate models within the budget; none if even the cheapest exceed it.
  std::optional<PlanChoice> of_budget;
  std::vector<std::string> remarks;

  bool MeetsBoth() const { return of_error && of_error->step_us <= demand.budget_us; }
};

/// Searches all organs of a scene in turn and chooses their models. `seconds` limits the searches
/// together; 0: no limit. Once `stopped`, no further model is tried. Throws InputError, also if
/// nothing is touched.
ScenePlan MakePlan(
    Scene scene, const PlanDemand& demand, double seconds,
    const std::function<void(const std::string&, const PlanPoint&)>& progress,
    const std::function<bool()>& stopped = [] { return false; });

/// Returns the cheapest models of at most `error`, if all organs have one.
std::optional<PlanChoice> ChooseWithin(const std::vector<OrganPlan>& organs, double error);

/// Returns the longest step of the chosen models, us. Each instrument touches one of the organs
/// that it reaches; two may touch the same one. Loads always act on their organ.
double LongestStep(const std::vector<OrganPlan>& organs,
                   const std::vector<std::optional<std::size_t>>& points);

/// Returns the text of the scene file with the chosen models. Its paths are relative to `folder`,
/// where the file will be written (scene_edit.h).
std::string PlannedScene(const Scene& scene, const ScenePlan& plan,
                         const std::filesystem::path& folder);

/// Reads `text` as the scene file `path`. Throws InputError if it is not a scene with the chosen
/// models.
void CheckPlannedScene(const std::string& text, const std::filesystem::path& path,
                       const ScenePlan& plan);

}  // namespace hpdm
