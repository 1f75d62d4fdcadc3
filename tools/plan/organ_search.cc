#include "tools/plan/organ_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/base/error.h"
#include "tools/chart/chart_measure.h"
#include "tools/shared/pareto_front.h"

namespace hpdm {
namespace {

constexpr double kBeyondBudget = 4;     // times the budget: slower models are still searched
constexpr double kSlowestSetup = 10e3;  // ms
constexpr double kHelps = 0.95;         // a refinement helps if its error is below this share of
                                        // the previous one
constexpr double kSurely = 0.8;         // a larger model takes at least this share of a smaller
                                        // one's time
constexpr double kHopeless = 0.5;       // a family stops if a faster model has this share of its
                                        // error
constexpr double kBeatenLater = 30;     // weight on the work of a family that is beaten

/// Search state of a family.
struct Progress {
  const PlanFamily* family = nullptr;
  std::size_t next = 0;  // index into its sizes
  bool ended = false;
  double last_error = std::numeric_limits<double>::infinity();
  double last_us = 0;
};

// True if another model is faster than the family's last member and has less than `share` of its
// error.
bool IsBeaten(const Progress& family, const std::vector<PlanPoint>& points, double share) {
  return std::any_of(points.begin(), points.end(), [&](const PlanPoint& point) {
    return point.choosable && point.converged && point.error < share * family.last_error &&
           point.MostMicroseconds() < family.last_us;
  });
}

// True if `larger` has at least as many functions of every kind, and the same solver.
bool IsLarger(const OrganOptions& larger, const OrganOptions& than) {
  if (larger.lattice.basis != than.lattice.basis || larger.energy.type != than.energy.type ||
      larger.energy.strain != than.energy.strain || larger.energy.solver != than.energy.solver ||
      LocalFunctionsOf(larger) < LocalFunctionsOf(than)) {
    return false;
  }
  for (int d = 0; d < 3; ++d) {
    if (larger.lattice.cells[d] < than.lattice.cells[d]) return false;
    if (larger.lattice.degree[d] < than.lattice.degree[d]) return false;
  }
  return true;
}

bool SurelyTooSlow(const OrganOptions& model, const std::vector<PlanPoint>& points, double limit) {
  return std::any_of(points.begin(), points.end(), [&](const PlanPoint& point) {
    return IsLarger(model, point.model) && kSurely * point.MostMicroseconds() > limit;
  });
}

}  // namespace

PlanPoint MeasureModel(const PlanFamily& family, const OrganOptions& model, const SurfaceMesh& rest,
                       const OrganTouches& touches, const ReferenceSolution& reference_solution) {
  PlanPoint point;
  point.family = family.name;
  point.model = model;
  point.choosable = family.Choosable();
  // Makes room for as many contacts as any case has.
  std::vector<LoadOptions> most = touches.patches;
  for (const std::vector<LoadOptions>& loads : touches.cases) {
    if (loads.size() > most.size()) most = loads;
  }
  const double start_ms = ThreadMilliseconds();
  StaticCaseModel body(rest, most, model);
  point.setup_ms = ThreadMilliseconds() - start_ms;
  point.control_points = body.unknowns();
  for (std::size_t i = 0; i < touches.cases.size(); ++i) {
    body.Reload(touches.cases[i]);
    const Points& reference = reference_solution.displacements[i];
    point.converged &= TakeToRest(rest, touches.cases[i], reference, model, &body);
    point.local_functions = std::max(
        point.local_functions, body.local_functions() / static_cast<int>(touches.cases[i].size()));
    point.answers.push_back(body.VertexDisplacements());
  }
  point.distance = PooledError(rest, point.answers, reference_solution.displacements);
  point.error = reference_solution.ErrorAt(point.distance);
  if (!std::isfinite(point.error)) point.converged = false;
  for (std::size_t contacts = 1; contacts <= touches.patches.size(); ++contacts) {
    const std::vector<LoadOptions> patches(
        touches.patches.begin(), touches.patches.begin() + static_cast<std::ptrdiff_t>(contacts));
    body.Reload(patches);
    if (family.Choosable()) {
      point.converged &= TakeToRest(rest, patches, Points(), model, &body);
    } else {
      body.MoveTo(Points::Constant(rest.vertices.rows(), 3, 1e-3));  // linear: any motion serves
    }
    const StaticCaseModel::StepTimes times = body.TimeSteps();
    point.converged &= times.last.converged;
    point.steps.push_back(Sum(Sum(times.response, times.relocation), times.indentations));
  }
  return point;
}

std::vector<PlanPoint> SearchOrgan(const OrganOptions& organ, const SurfaceMesh& rest,
                                   const OrganTouches& touches,
                                   const ReferenceSolution& reference_solution,
                                   const SearchOptions& options,
                                   const std::function<void(const PlanPoint&)>& progress,
                                   std::vector<std::string>* remarks) {
  const TimingClock::time_point start = TimingClock::now();
  const std::vector<PlanFamily> families = PlanFamilies(reference_solution.finite);
  std::vector<Progress> searched;
  for (const PlanFamily& family : families) searched.push_back({.family = &family});
  std::vector<PlanPoint> points;
  double limit = kBeyondBudget * options.budget_us;
  for (;;) {
    Progress* next = nullptr;
    OrganOptions model;
    double least = std::numeric_limits<double>::infinity();
    for (Progress& each : searched) {
      if (each.ended || each.next == each.family->sizes.size()) continue;
      const OrganOptions member =
          MemberOf(*each.family, each.family->sizes[each.next], organ, rest);
      if (IsBeaten(each, points, kHopeless) || SurelyTooSlow(member, points, limit)) {
        each.ended = true;
        continue;
      }
      const double work = SetupWork(member) * (IsBeaten(each, points, 1) ? kBeatenLater : 1);
      if (work < least) {
        least = work;
        next = &each;
        model = member;
      }
    }
    if (next == nullptr) break;
    const bool late = options.deadline_ms > 0 && MillisecondsSince(start) > options.deadline_ms;
    if (late || options.stopped()) {
      remarks->push_back("organ \"" + organ.name + "\": the search " +
                         (late ? "ended at its deadline" : "was interrupted") +
                         "; there may be a better model");
      break;
    }
    ++next->next;
    PlanPoint point;
    try {
      point = MeasureModel(*next->family, model, rest, touches, reference_solution);
    } catch (const InputError&) {  // too large, or not positive definite
      next->ended = true;
      continue;
    }
    const bool meets = point.choosable && point.converged && point.error <= options.error;
    if (meets) limit = std::min(limit, point.MostMicroseconds());
    next->ended = meets || point.MostMicroseconds() > limit || point.setup_ms > kSlowestSetup ||
                  (point.error > options.error && point.error > kHelps * next->last_error);
    next->last_error = point.error;
    next->last_us = point.MostMicroseconds();
    progress(point);
    points.push_back(std::move(point));
  }
  return points;
}

std::vector<std::size_t> PlanFront(const std::vector<PlanPoint>& points) {
  std::vector<CostAndError> costs;
  for (const PlanPoint& point : points) {
    // A model that cannot be chosen needs no step times.
    const bool counts = point.choosable && point.converged;
    costs.push_back({counts, counts ? point.MostMicroseconds() : 0, point.error});
  }
  return ParetoFront(costs);
}

std::optional<std::size_t> CheapestWithin(const std::vector<PlanPoint>& points, double error) {
  for (const std::size_t i : PlanFront(points)) {
    if (points[i].error <= error) return i;
  }
  return std::nullopt;
}

}  // namespace hpdm
