#include "tools/plan/plan_report.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tools/shared/json_rows.h"
#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;

/// Marks of the points of one organ in the report.
struct PointMarks {
  std::vector<std::size_t> order;  // from fast to slow
  std::vector<bool> front;
  std::optional<std::size_t> chosen;
};

PointMarks PointMarksOf(const ScenePlan& plan, std::size_t o) {
  const std::vector<PlanPoint>& points = plan.organs[o].points;
  PointMarks marks{std::vector<std::size_t>(points.size()), std::vector<bool>(points.size()), {}};
  std::iota(marks.order.begin(), marks.order.end(), std::size_t{0});
  std::stable_sort(marks.order.begin(), marks.order.end(), [&](std::size_t a, std::size_t b) {
    return points[a].MostMicroseconds() < points[b].MostMicroseconds();
  });
  for (const std::size_t i : PlanFront(points)) marks.front[i] = true;
  if (plan.MeetsBoth()) marks.chosen = plan.of_error->points[o];
  return marks;
}

std::string Contacts(const OrganPlan& organ) {
  const std::size_t contacts = organ.touches.patches.size();
  return Format("%zu contact%s", contacts, contacts == 1 ? "" : "s");
}

std::string FateText(const OrganPlan& organ) {
  if (organ.fate == OrganFate::kRigid) return "becomes rigid";
  return "stays as it is";
}

std::string ReferenceText(const OrganPlan& organ) {
  const ReferenceSolution& reference_solution = organ.reference_solution;
  return Format(
      "%zu %s, judged by %s control points (%d cells along the longest side), uncertainty "
      "%.1f %%%s",
      organ.touches.cases.size(), organ.touches.from_scene ? "load case" : "places to press",
      WithCommas(reference_solution.control_points).c_str(), reference_solution.cells,
      100 * reference_solution.doubt,
      reference_solution.finite
          ? Format(", including finite strain's %.1f %%", 100 * reference_solution.finite_share)
                .c_str()
          : "");
}

Json StepsOf(const PlanPoint& point) {
  Json steps = Json::array();
  for (const Timing& step : point.steps) steps.push_back(step.median_us);
  return steps;
}

Json PointJson(const PlanPoint& point, bool front, bool chosen) {
  const LatticeOptions& lattice = point.model.lattice;
  return {
      {"family", point.family},
      {"model", DescribeModel(point.model)},
      {"basis", lattice.basis == BasisType::kBSpline ? "bspline" : "bernstein"},
      {"degree", lattice.degree[0]},
      {"cells", lattice.cells},
      {"margin_m", lattice.margin},
      {"local_functions", LocalFunctionsOf(point.model)},
      {"local_refinement", lattice.local.refinement},
      {"energy", point.model.energy.type == EnergyType::kStrain ? "strain" : "metric"},
      {"strain", StrainName(point.model.energy.strain)},
      {"solver", point.model.energy.solver == SolverType::kCholesky ? "cholesky" : "gauss_seidel"},
      {"control_points", point.control_points},
      {"error", point.error},
      {"distance", point.distance},
      {"step_us", StepsOf(point)},
      {"setup_ms", point.setup_ms},
      {"converged", point.converged},
      {"choosable", point.choosable},
      {"front", front},
      {"chosen", chosen}};
}

Json ChoiceJson(const std::optional<PlanChoice>& choice) {
  if (!choice) return nullptr;
  return {{"error", choice->error}, {"step_us", choice->step_us}};
}

}  // namespace

std::string PlanText(const ScenePlan& plan) {
  std::string text;
  for (std::size_t o = 0; o < plan.organs.size(); ++o) {
    const OrganPlan& organ = plan.organs[o];
    text += organ.name + (organ.hollow ? " (hollow): " : ": ");
    if (organ.fate != OrganFate::kSearched) {
      text += FateText(organ) + "\n";
      continue;
    }
    text += ReferenceText(organ) + "\n";
    text += "      error       step   set-up  control points, model; step of " + Contacts(organ) +
            "; * best for its time, > chosen\n";
    const PointMarks marks = PointMarksOf(plan, o);
    for (const std::size_t i : marks.order) {
      const PlanPoint& point = organ.points[i];
      text += Format("  %c%c %5.1f %% %10s %8s  %5d  %s%s\n", marks.chosen == i ? '>' : ' ',
                     marks.front[i] ? '*' : ' ', 100 * point.error,
                     Duration(point.MostMicroseconds()).c_str(),
                     Duration(1e3 * point.setup_ms).c_str(), point.control_points,
                     DescribeModel(point.model).c_str(), point.converged ? "" : " (not converged)");
    }
  }
  return text;
}

std::string VerdictText(const ScenePlan& plan) {
  const PlanDemand& demand = plan.demand;
  const std::string asked =
      Format("%.3g %% within %s", 100 * demand.error, Duration(demand.budget_us).c_str());
  if (plan.MeetsBoth()) {
    return Format("%s: met, estimated error %.1f %%, longest step %s\n", asked.c_str(),
                  100 * plan.of_error->error, Duration(plan.of_error->step_us).c_str());
  }
  std::string text = asked + ": cannot be met\n";
  if (plan.of_error) {
    text +=
        Format("  the error needs %s a step, %.2g times the budget\n",
               Duration(plan.of_error->step_us).c_str(), plan.of_error->step_us / demand.budget_us);
  } else {
    for (const OrganPlan& organ : plan.organs) {
      if (organ.fate != OrganFate::kSearched) continue;
      const double doubt = organ.reference_solution.doubt;
      if (!organ.reference_solution.Judges(demand.error)) {
        text += Format(
            "  the reference solution of %s is in doubt by %.1f %%: nothing below %.0f %% is "
            "promised\n",
            organ.name.c_str(), 100 * doubt, std::ceil(200 * doubt));
        continue;
      }
      if (CheapestWithin(organ.points, demand.error)) continue;
      const std::vector<std::size_t> front = PlanFront(organ.points);
      text += "  no tried model of " + organ.name + " meets the error";
      if (!front.empty()) {
        const PlanPoint& best = organ.points[front.back()];
        text += Format("; the best has %.1f %%, %.2g times as much, in %s", 100 * best.error,
                       best.error / demand.error, Duration(best.MostMicroseconds()).c_str());
      }
      text += "\n";
    }
  }
  if (plan.of_budget) {
    text += Format("  the budget leaves an error of %.1f %%, %.2g times as much as asked for\n",
                   100 * plan.of_budget->error, plan.of_budget->error / demand.error);
  } else {
    text += "  even the cheapest tried models exceed the budget\n";
  }
  return text;
}

std::string PlanMarkdown(const ScenePlan& plan, const std::string& scene,
                         const std::string& machine) {
  std::string text =
      "| organ | model | estimated error | step | set-up | |\n|---|---|---|---|---|---|\n";
  for (std::size_t o = 0; o < plan.organs.size(); ++o) {
    const OrganPlan& organ = plan.organs[o];
    if (organ.fate != OrganFate::kSearched) {
      text += "| " + organ.name + " | " + FateText(organ) + " | - | - | - | |\n";
      continue;
    }
    const PointMarks marks = PointMarksOf(plan, o);
    for (const std::size_t i : marks.order) {
      if (!marks.front[i]) continue;
      const PlanPoint& point = organ.points[i];
      text += Format("| %s | %s, n %d | %.1f %% | %s | %s | %s |\n", organ.name.c_str(),
                     DescribeModel(point.model).c_str(), point.control_points, 100 * point.error,
                     Duration(point.MostMicroseconds()).c_str(),
                     Duration(1e3 * point.setup_ms).c_str(), marks.chosen == i ? "**chosen**" : "");
    }
  }
  const std::string verdict = VerdictText(plan);
  text += "\n`" + scene + "`, " + verdict.substr(0, verdict.find('\n')) + ". ";
  for (const OrganPlan& organ : plan.organs) {
    if (organ.fate != OrganFate::kSearched) continue;
    text += organ.name + ": " + ReferenceText(organ) + ". ";
  }
  return text + "Step: median; reposition, relax, relocate its own vertices; " + machine + ".\n";
}

Json ToJson(const ScenePlan& plan) {
  Json json = {{"error", plan.demand.error},
               {"budget_us", plan.demand.budget_us},
               {"met", plan.MeetsBoth()},
               {"of_error", ChoiceJson(plan.of_error)},
               {"of_budget", ChoiceJson(plan.of_budget)},
               {"organs", Json::array()}};
  for (std::size_t o = 0; o < plan.organs.size(); ++o) {
    const OrganPlan& organ = plan.organs[o];
    Json of_organ = {{"name", organ.name},
                     {"fate", organ.fate == OrganFate::kSearched ? "searched"
                              : organ.fate == OrganFate::kRigid  ? "rigid"
                                                                 : "as_it_is"},
                     {"hollow", organ.hollow}};
    if (organ.fate == OrganFate::kSearched) {
      of_organ["cases"] = organ.touches.cases.size();
      of_organ["contacts"] = organ.touches.patches.size();
      const ReferenceSolution& reference = organ.reference_solution;
      of_organ["reference_solution"] = {{"cells", reference.cells},
                                        {"control_points", reference.control_points},
                                        {"uncertainty", reference.doubt},
                                        {"finite_strain_change", reference.finite_share},
                                        {"finite_strain", reference.finite}};
      // Deprecated: the same under the former names.
      of_organ["yardstick"] = {{"cells", reference.cells},
                               {"control_points", reference.control_points},
                               {"doubt", reference.doubt},
                               {"finite_share", reference.finite_share},
                               {"finite", reference.finite}};
      const PointMarks marks = PointMarksOf(plan, o);
      of_organ["points"] = Json::array();
      for (const std::size_t i : marks.order) {
        of_organ["points"].push_back(PointJson(organ.points[i], marks.front[i], marks.chosen == i));
      }
    }
    json["organs"].push_back(of_organ);
  }
  return json;
}

std::string PlanCsv(const ScenePlan& plan, const std::vector<std::string>& header) {
  std::string text;
  for (const std::string& line : header) text += "# " + line + "\n";
  bool named = false;
  for (std::size_t o = 0; o < plan.organs.size(); ++o) {
    const OrganPlan& organ = plan.organs[o];
    const PointMarks marks = PointMarksOf(plan, o);
    for (const std::size_t i : marks.order) {
      const PlanPoint& point = organ.points[i];
      const Json row = {{"organ", organ.name},
                        {"hollow", organ.hollow ? 1 : 0},
                        {"family", point.family},
                        {"model", DescribeModel(point.model)},
                        {"control_points", point.control_points},
                        {"local_functions", point.local_functions},
                        {"error", point.error},
                        {"step_us", point.MostMicroseconds()},
                        {"setup_ms", point.setup_ms},
                        {"converged", point.converged ? 1 : 0},
                        {"choosable", point.choosable ? 1 : 0},
                        {"front", marks.front[i] ? 1 : 0},
                        {"chosen", marks.chosen == i ? 1 : 0},
                        {"doubt", organ.reference_solution.doubt},
                        {"demand_error", plan.demand.error},
                        {"demand_us", plan.demand.budget_us}};
      if (!named) text += CsvNames(row);
      named = true;
      text += CsvValues(row);
    }
  }
  return text;
}

}  // namespace hpdm
