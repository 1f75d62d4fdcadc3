#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tools/plan/organ_search.h"

namespace hpdm {

/// What is asked of a scene.
struct PlanDemand {
  double error = 0;      ///< Of each organ that is touched: relative L2 of its surface's motion.
  double budget_us = 0;  ///< Of a deformation step: all organs that can be touched at once.
};

/// What becomes of an organ.
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

/// A model for each organ (none: not searched), what they cost together, and the largest error.
struct PlanChoice {
  std::vector<std::optional<std::size_t>> points;
  double step_us = 0;
  double error = 0;
};

struct ScenePlan {
  PlanDemand demand;
  std::vector<OrganPlan> organs;
  /// The cheapest models of at most the error asked for, whatever they cost; none where an organ
  /// has no such model among those searched.
  std::optional<PlanChoice> of_error;
  /// The most accurate within the budget; none where even the cheapest exceed it.
  std::optional<PlanChoice> of_budget;
  std::vector<std::string> remarks;

  bool MeetsBoth() const { return of_error && of_error->step_us <= demand.budget_us; }
};

/// Searches all organs of a scene, one after the other, and chooses. `seconds` for the searches
/// together, 0: no limit. Throws InputError, also when nothing is touched.
ScenePlan MakePlan(const Scene& scene, const PlanDemand& demand, double seconds,
                   const std::function<void(const std::string&, const PlanPoint&)>& progress);

/// The cheapest models of at most `error`, if all organs have one.
std::optional<PlanChoice> ChooseWithin(const std::vector<OrganPlan>& organs, double error);

/// The longest step that chosen models can make, us: each instrument touches one of the organs that
/// it reaches, two may touch the same one, and loads act on their organ always.
double LongestStep(const std::vector<OrganPlan>& organs,
                   const std::vector<std::optional<std::size_t>>& points);

/// The scene's text with the chosen models for one that is to stand in `folder` (scene_edit.h).
std::string PlannedScene(const Scene& scene, const ScenePlan& plan,
                         const std::filesystem::path& folder);

/// Throws InputError unless a text, standing at `path`, is a scene of the chosen models.
void CheckPlannedScene(const std::string& text, const std::filesystem::path& path,
                       const ScenePlan& plan);

}  // namespace hpdm
