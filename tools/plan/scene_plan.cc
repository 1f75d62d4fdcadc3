#include "tools/plan/scene_plan.h"

#include <algorithm>
#include <set>

#include "engine/base/error.h"
#include "engine/mesh/mesh_facts.h"
#include "engine/organ.h"
#include "tools/session/scene_defaults.h"
#include "tools/shared/static_case.h"
#include "tools/shared/with_scene_path.h"

namespace hpdm {
namespace {

// Finds the worst case of contacts per organ by trying every organ that each instrument may touch.
void TryTouches(const std::vector<OrganPlan>& organs,
                const std::vector<std::optional<std::size_t>>& points, std::size_t instrument,
                std::size_t instruments, std::vector<std::size_t>* contacts, double* longest) {
  if (instrument == instruments) {
    double sum = 0;
    for (std::size_t o = 0; o < organs.size(); ++o) {
      if (!points[o]) continue;
      const std::vector<Timing>& steps = organs[o].points[*points[o]].steps;
      const std::size_t most = organs[o].touches.from_scene ? steps.size() : (*contacts)[o];
      if (most > 0) sum += steps[std::min(most, steps.size()) - 1].median_us;
    }
    *longest = std::max(*longest, sum);
    return;
  }
  TryTouches(organs, points, instrument + 1, instruments, contacts, longest);
  for (std::size_t o = 0; o < organs.size(); ++o) {
    const std::vector<std::size_t>& reach = organs[o].touches.instruments;
    if (!points[o] || std::find(reach.begin(), reach.end(), instrument) == reach.end()) continue;
    ++(*contacts)[o];
    TryTouches(organs, points, instrument + 1, instruments, contacts, longest);
    --(*contacts)[o];
  }
}

bool CanBeRigid(const OrganOptions& organ, const SurfaceMesh& rest) {
  try {
    OrganOptions rigid = organ;
    rigid.model = OrganModelType::kRigid;
    return OrganModel(rigid, rest).rigid();
  } catch (const InputError&) {
    return false;
  }
}

// Scales the presses by a typical hand: the first that reaches the organ.
void Scale(const Scene& scene, const OrganOptions& organ, const SurfaceMesh& rest,
           OrganTouches* touches) {
  if (touches->from_scene) return;
  const HandOptions& hand = scene.instruments[touches->instruments.front()].hand;
  ScalePresses(organ, rest, hand.stiffness, hand.depth, touches);
}

}  // namespace

double LongestStep(const std::vector<OrganPlan>& organs,
                   const std::vector<std::optional<std::size_t>>& points) {
  std::size_t instruments = 0;
  for (const OrganPlan& organ : organs) {
    for (const std::size_t i : organ.touches.instruments)
      instruments = std::max(instruments, i + 1);
  }
  std::vector<std::size_t> contacts(organs.size(), 0);
  double longest = 0;
  TryTouches(organs, points, 0, instruments, &contacts, &longest);
  return longest;
}

std::optional<PlanChoice> ChooseWithin(const std::vector<OrganPlan>& organs, double error) {
  PlanChoice choice;
  for (const OrganPlan& organ : organs) {
    choice.points.emplace_back();
    if (organ.fate != OrganFate::kSearched) continue;
    choice.points.back() = CheapestWithin(organ.points, error);
    if (!choice.points.back()) return std::nullopt;
    choice.error = std::max(choice.error, organ.points[*choice.points.back()].error);
  }
  choice.step_us = LongestStep(organs, choice.points);
  return choice;
}

ScenePlan MakePlan(Scene scene, const PlanDemand& demand, double seconds,
                   const std::function<void(const std::string&, const PlanPoint&)>& progress,
                   const std::function<bool()>& stopped) {
  const TimingClock::time_point start = TimingClock::now();
  ScenePlan plan;
  plan.demand = demand;
  std::vector<SurfaceMesh> rests;
  for (OrganOptions& organ : scene.organs) {
    std::vector<std::string> repairs;
    rests.push_back(WithScenePlace(scene, [&] { return LoadPosedMesh(organ, &repairs); }));
    HoldRear(scene, rests.back(), &organ);  // as in the session that will run
  }
  std::vector<OrganTouches> touches = FindTouches(scene, rests);
  if (std::none_of(touches.begin(), touches.end(),
                   [](const OrganTouches& each) { return each.Touched(); })) {
    throw InputError(scene.path.string() +
                     ": nothing touches an organ that deforms; add an [[instrument]] that reaches "
                     "one, or a [[load]]");
  }
  for (std::size_t o = 0; o < scene.organs.size(); ++o) {
    const OrganOptions& organ = scene.organs[o];
    OrganPlan& planned = plan.organs.emplace_back();
    planned.name = organ.name;
    planned.hollow = IsHollow(rests[o]);
    planned.touches = std::move(touches[o]);
    if (planned.touches.Touched()) {
      planned.fate = OrganFate::kSearched;
      WithScenePath(scene, [&] {
        Scale(scene, organ, rests[o], &planned.touches);
        planned.reference_solution =
            MakeReferenceSolution(organ, rests[o], planned.touches, demand.error, &plan.remarks);
      });
      const double left = seconds > 0 ? std::max(1.0, 1e3 * seconds - MillisecondsSince(start)) : 0;
      planned.points = SearchOrgan(
          organ, rests[o], planned.touches, planned.reference_solution,
          {demand.error, demand.budget_us, left, stopped},
          [&](const PlanPoint& point) { progress(organ.name, point); }, &plan.remarks);
    } else if (organ.model != OrganModelType::kRigid) {
      const bool can_be = CanBeRigid(organ, rests[o]);
      planned.fate = can_be ? OrganFate::kRigid : OrganFate::kAsItIs;
      plan.remarks.push_back(
          "organ \"" + organ.name + "\": no instrument reaches it; " +
          (can_be ? "it becomes rigid" : "its mesh is open, so it cannot become rigid"));
    }
  }
  const bool judged = std::all_of(
      plan.organs.begin(), plan.organs.end(),
      [&](const OrganPlan& organ) { return organ.reference_solution.Judges(demand.error); });
  if (judged) plan.of_error = ChooseWithin(plan.organs, demand.error);
  std::set<double> errors;
  for (const OrganPlan& organ : plan.organs) {
    for (const PlanPoint& point : organ.points) errors.insert(point.error);
  }
  for (const double error : errors) {
    plan.of_budget = ChooseWithin(plan.organs, error);
    if (plan.of_budget && plan.of_budget->step_us <= demand.budget_us) break;
    plan.of_budget.reset();
  }
  return plan;
}

}  // namespace hpdm
