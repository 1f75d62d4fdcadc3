#include "tools/chart/chart_measure.h"

#include <algorithm>

#include "engine/baselines/skin.h"

namespace hpdm {
namespace {

// Returns the factor on `u` that brings it nearest to `reference` in the norm of
// RelativeSurfaceError.
double BestScale(const SurfaceMesh& rest, const Points& u, const Points& reference) {
  const Eigen::VectorXd areas = VertexAreas(rest);
  return areas.dot(u.cwiseProduct(reference).rowwise().sum()) /
         areas.dot(u.rowwise().squaredNorm());
}

// Moves a model without a modulus in pascals to the reference solution's patch displacements. If
// the loads are forces, scales the depth to the least error. No tuning of its stiffness could do
// better.
void FollowAtBestDepth(const SurfaceMesh& rest, const std::vector<LoadOptions>& loads,
                       const Points& reference, StaticCaseModel* body) {
  const bool depth_is_given = std::all_of(loads.begin(), loads.end(), [](const LoadOptions& load) {
    return load.displacement_W.has_value();
  });
  double depth = 1;
  body->MoveTo(reference);
  for (int round = 0; !depth_is_given && round < 3; ++round) {  // a linear model needs one round
    const double better = BestScale(rest, body->VertexDisplacements(), reference);
    if (!(better > 0)) return;
    depth *= better;
    body->MoveTo(depth * reference);
  }
}

}  // namespace

bool HasModulus(const OrganOptions& options) {
  return options.model == OrganModelType::kHpdm && options.energy.type == EnergyType::kStrain;
}

ChartPoint Labelled(const std::string& load_case, bool hollow, const OrganOptions& options) {
  ChartPoint point;
  point.load_case = load_case;
  point.hollow = hollow;
  if (options.model != OrganModelType::kHpdm) {
    const bool continuum = options.model == OrganModelType::kContinuum;
    point.model = continuum ? "continuum" : "mass_spring";
    point.solver = continuum ? "cholesky" : "explicit";
    return point;
  }
  const EnergyOptions& energy = options.energy;
  const bool strain = energy.type == EnergyType::kStrain;
  const bool finite = energy.strain == StrainMeasure::kFinite;
  point.model = "hpdm";
  point.energy = strain ? "strain" : "metric";
  point.strain = strain ? (finite ? "finite" : "small")
                        : (energy.domain == EnergyDomain::kOrgan ? "organ" : "box");
  point.solver = finite                                      ? "newton"
                 : energy.solver == SolverType::kGaussSeidel ? "gauss_seidel"
                                                             : "cholesky";
  point.basis = options.lattice.basis == BasisType::kBSpline ? "bspline" : "bernstein";
  point.degree = options.lattice.degree[0];
  point.cells = options.lattice.cells;
  point.local_functions = LocalFunctionsOf(options);
  point.local_refinement = point.local_functions > 0 ? options.lattice.local.refinement : 0;
  point.adaptive_levels =
      options.lattice.adaptive.functions > 0 ? options.lattice.adaptive.levels : 0;
  return point;
}

bool TakeToRest(const SurfaceMesh& rest, const std::vector<LoadOptions>& loads,
                const Points& reference, const OrganOptions& options, StaticCaseModel* body) {
  if (options.model == OrganModelType::kHpdm && options.energy.solver == SolverType::kGaussSeidel) {
    OrganOptions direct = options;
    direct.energy.solver = SolverType::kCholesky;
    StaticCaseModel twin(rest, loads, direct);
    const bool balanced = TakeToRest(rest, loads, reference, direct, &twin);
    body->StartFrom(twin);
    return balanced;
  }
  if (HasModulus(options)) return body->Balance();
  FollowAtBestDepth(rest, loads, reference, body);
  return true;
}

}  // namespace hpdm
