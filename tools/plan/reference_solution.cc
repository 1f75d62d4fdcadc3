#include "tools/plan/reference_solution.h"

#include <algorithm>
#include <cmath>

#include "engine/base/error.h"
#include "engine/baselines/skin.h"
#include "engine/organ.h"
#include "engine/reference_fem/fine_lattice.h"
#include "engine/statics/static_loads.h"
#include "tools/shared/report_text.h"
#include "tools/shared/static_case.h"

namespace hpdm {
namespace {

constexpr int kLevels[] = {12, 16, 24, 32, 48};
constexpr int kMaxControlPoints = 15000;  // the next level may have three times as many
constexpr double kEnough = 0.4;           // share of the demanded error that may remain uncertain
constexpr double kFiniteMatters = 0.5;    // share of the demanded error

OrganOptions CoarseModel(const OrganOptions& organ, StrainMeasure strain) {
  OrganOptions options = organ;
  options.model = OrganModelType::kHpdm;
  options.energy.type = EnergyType::kStrain;
  options.energy.strain = strain;
  options.energy.solver = SolverType::kCholesky;
  options.lattice = LatticeOptions();
  options.lattice.margin = organ.lattice.margin;
  options.lattice.local.functions = 0;
  return options;
}

// Returns the change that finite strain makes in each case, on a coarse lattice.
std::vector<Points> FiniteDifferences(const OrganOptions& organ, const SurfaceMesh& rest,
                                      const OrganTouches& touches, double* share,
                                      std::vector<std::string>* remarks) {
  const OrganModel small(CoarseModel(organ, StrainMeasure::kSmall), rest);
  const OrganModel finite(CoarseModel(organ, StrainMeasure::kFinite), rest);
  std::vector<Points> differences, bent_shapes, straight_shapes;
  *share = 0;
  for (const std::vector<LoadOptions>& loads : touches.cases) {
    const StaticSolution bent = StaticLoads(finite, loads).Solve();
    const Points straight = StaticLoads(small, loads).Solve().vertex_displacements;
    if (bent.share < 1) {
      remarks->push_back("organ \"" + organ.name +
                         "\": no equilibrium in finite strain under its loads; judged in "
                         "small strain");
      return {};
    }
    differences.push_back(bent.vertex_displacements - straight);
    bent_shapes.push_back(bent.vertex_displacements);
    straight_shapes.push_back(straight);
  }
  *share = PooledError(rest, straight_shapes, bent_shapes);
  return differences;
}

}  // namespace

double PooledError(const SurfaceMesh& rest, const std::vector<Points>& u,
                   const std::vector<Points>& reference) {
  const Eigen::VectorXd areas = VertexAreas(rest);
  double apart = 0, moved = 0;
  for (std::size_t i = 0; i < u.size(); ++i) {
    apart += areas.dot((u[i] - reference[i]).rowwise().squaredNorm());
    moved += areas.dot(reference[i].rowwise().squaredNorm());
  }
  return std::sqrt(apart / moved);
}

double ReferenceSolution::ErrorAt(double distance) const {
  return split ? distance + doubt : std::hypot(distance, doubt);
}

double ReferenceDoubt(const std::vector<double>& changes, bool split) {
  const double last = changes.back();
  if (changes.size() < 2) return last;
  const double before = changes[changes.size() - 2];
  const double rate = std::min(last / before, 0.75);
  const double follows = last * rate / (1 - rate);
  return std::max({last, follows, split ? before / 2 : 0});
}

ReferenceSolution MakeReferenceSolution(const OrganOptions& organ, const SurfaceMesh& rest,
                                        const OrganTouches& touches, double error,
                                        std::vector<std::string>* remarks) {
  RequireTissueAlone(organ);
  ReferenceSolution reference_solution;
  std::vector<double> changes;
  for (const int cells : kLevels) {
    const FineLattice lattice(organ, rest, cells);
    std::vector<Points> finer = lattice.Displacements(touches.cases);
    if (!reference_solution.displacements.empty()) {
      changes.push_back(PooledError(rest, reference_solution.displacements, finer));
    }
    reference_solution.displacements = std::move(finer);
    reference_solution.doubt = changes.empty() ? 1 : ReferenceDoubt(changes, lattice.split());
    reference_solution.cells = cells;
    reference_solution.split = lattice.split();
    reference_solution.control_points = lattice.control_points();
    const bool enough = reference_solution.doubt <= kEnough * error &&
                        changes.size() >= (lattice.split() ? 2U : 1U);
    if (enough || 3 * reference_solution.control_points > kMaxControlPoints) break;
  }
  if (reference_solution.doubt > kEnough * error) {
    remarks->push_back("organ \"" + organ.name +
                       "\": the finest lattice leaves an uncertainty above 0.4 of the "
                       "demanded error; the estimates are no better than that");
  }
  const std::vector<Points> differences =
      FiniteDifferences(organ, rest, touches, &reference_solution.finite_share, remarks);
  const bool matters = reference_solution.finite_share > kFiniteMatters * error;
  reference_solution.finite = matters && organ.energy.strain != StrainMeasure::kSmall;
  if (matters && !reference_solution.finite) {
    remarks->push_back("organ \"" + organ.name +
                       "\": judged in small strain, as the scene says; finite strain "
                       "would change the result by " +
                       Format("%.0f %%", 100 * reference_solution.finite_share) +
                       "; give strain = \"finite\" to include it");
  }
  for (std::size_t i = 0; reference_solution.finite && i < differences.size(); ++i) {
    reference_solution.displacements[i] += differences[i];
  }
  return reference_solution;
}

void ScalePresses(const OrganOptions& organ, const SurfaceMesh& rest, double stiffness,
                  double depth, OrganTouches* touches) {
  if (touches->from_scene) return;
  const OrganModel coarse(CoarseModel(organ, StrainMeasure::kSmall), rest);
  const auto scale = [&](LoadOptions* press) {
    press->force_W->normalize();
    const double compliance = StaticLoads(coarse, {*press}).Solve().Compliance();
    *press->force_W *= stiffness * depth / (1 + stiffness * compliance);
  };
  for (std::vector<LoadOptions>& loads : touches->cases) scale(&loads.front());
  for (LoadOptions& patch : touches->patches) scale(&patch);
}

}  // namespace hpdm
