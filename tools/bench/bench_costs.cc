#include <algorithm>

#include "engine/mesh/collision.h"
#include "tools/bench/bench_model.h"
#include "tools/bench/bench_results.h"
#include "tools/shared/flat_subdivision.h"

namespace hpdm {
namespace {

// Smaller sizes are left out of the fit: set-up, which samples the tissue, costs about the same for
// all of them.
constexpr double kVerticesFittedFrom = 2000;
constexpr double kControlPointsFittedFrom = 60;
constexpr double kSetUpFittedFrom = 300;

RepeatOptions CostRepeats(bool quick) {
  return quick ? RepeatOptions{3, 100, 20} : RepeatOptions{5, 500, 300};
}

CostCurve EmptyCurve(const char* what, const char* of, double fitted_from) {
  CostCurve curve;
  curve.what = what;
  curve.of = of;
  curve.fitted_from = fitted_from;
  return curve;
}

void Add(double size, const Timing& timing, CostCurve* curve) {
  curve->size.push_back(size);
  curve->us.push_back(timing.minimum_us);
}

void Fit(CostCurve* curve) {
  std::vector<double> size, us;
  for (std::size_t i = 0; i < curve->size.size(); ++i) {
    if (curve->size[i] < curve->fitted_from) continue;
    size.push_back(curve->size[i]);
    us.push_back(curve->us[i]);
  }
  curve->law = FitPowerLaw(size, us);
}

}  // namespace

std::vector<CostCurve> CostOfVertices(bool quick) {
  const auto curve = [](const char* what) {
    return EmptyCurve(what, "vertices", kVerticesFittedFrom);
  };
  CostCurve relocation = curve("relocate (strain, 6^3 cells)");
  CostCurve refit = curve("refit the collision tree");
  CostCurve continuum = curve("surface continuum, factorised once: whole step");
  const Eigen::Index most = quick ? 40000 : 500000;
  const Eigen::Index most_of_continuum = quick ? 9000 : 36000;  // the factors of larger ones take
                                                                // seconds

  // The lattice samples the same tissue for every triangle count, so one organ model serves all
  // sizes.
  BenchOrgan organ = MakeBenchOrgan("liver_274");
  organ.options.lattice.cells = {6, 6, 6};
  const OrganModel model(organ.options, organ.rest);
  const Points U = 1e-3 * Points::Random(model.weights().cols(), 3);
  for (organ.rest = FlatSubdivided(organ.rest);; organ.rest = FlatSubdivided(organ.rest)) {
    const double size = static_cast<double>(organ.rest.vertices.rows());
    const Relocation relocate(organ.rest.vertices,
                              model.lattice_organ()->lattice().Weights(organ.rest.vertices));
    Points vertices = organ.rest.vertices;
    SurfaceTree tree(organ.rest.vertices, organ.rest.triangles);
    const auto times =
        TimeInTurn({[&] { relocate.Relocate(U, &vertices); }, [&] { tree.Refit(vertices); }},
                   CostRepeats(quick));
    Add(size, Summary(times[0]), &relocation);
    Add(size, Summary(times[1]), &refit);
    if (organ.rest.vertices.rows() <= most_of_continuum) {
      BenchModel body(organ, ContinuumStep::kPrefactored);
      Add(size, Time([&] { body.Step(); }, CostRepeats(quick)), &continuum);
    }
    if (organ.rest.vertices.rows() >= most) break;
  }
  std::vector<CostCurve> curves = {relocation, refit, continuum};
  for (CostCurve& each : curves) Fit(&each);
  return curves;
}

std::vector<CostCurve> CostOfControlPoints(bool quick) {
  const auto curve = [](const char* what) {
    return EmptyCurve(what, "control points", kControlPointsFittedFrom);
  };
  CostCurve strain = curve("step, strain, Cholesky, liver_1332");
  CostCurve setup = curve("set-up, strain");
  setup.fitted_from = kSetUpFittedFrom;
  CostCurve metric = curve("step, metric, Cholesky, liver_1332");
  BenchOrgan organ = MakeBenchOrgan("liver_1332");
  // Starts at the 8 corners of the box: Bernstein of degree 1 and 2, then B-splines.
  std::vector<LatticeOptions> lattices(2);
  for (int degree = 1; degree <= 2; ++degree) {
    lattices[degree - 1].basis = BasisType::kBernstein;
    lattices[degree - 1].degree = {degree, degree, degree};
    lattices[degree - 1].cells = {1, 1, 1};
  }
  for (const int n :
       quick ? std::vector<int>{2, 4, 6, 8} : std::vector<int>{2, 3, 4, 6, 8, 10, 13}) {
    lattices.emplace_back();
    lattices.back().cells = {n, n, n};
  }
  for (const LatticeOptions& lattice : lattices) {
    organ.options.lattice = lattice;
    organ.options.lattice.local.functions = 0;
    // With trilinear functions on one cell the supports fix only the mean displacement. Rotation
    // stays free, and it costs the strain energy nothing.
    const bool rotates_freely = lattice.degree[0] == 1;
    for (CostCurve* of : {&strain, &metric}) {
      if (of == &strain && rotates_freely) continue;
      organ.options.energy.type = of == &strain ? EnergyType::kStrain : EnergyType::kMetric;
      BenchModel body(organ);
      Add(body.unknowns(), Time([&] { body.Step(); }, CostRepeats(quick)), of);
      const double us = 1000 * body.setup_ms();
      if (of == &strain) Add(body.unknowns(), {us, us}, &setup);
    }
  }
  std::vector<CostCurve> curves = {strain, metric, setup};
  for (CostCurve& each : curves) Fit(&each);
  return curves;
}

}  // namespace hpdm
