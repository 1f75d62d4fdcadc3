#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "engine/baselines/surface_error.h"
#include "engine/reference_fem/tetra_fem.h"
#include "tools/shared/report_text.h"
#include "tools/stress/material_cases.h"
#include "tools/stress/stress_block_fixture.h"

namespace hpdm {
namespace {

// Returns the end displacement of a square cantilever per unit force, m/N (Timoshenko).
double BeamCompliance(double length, double thickness, double young) {
  const double area = thickness * thickness, inertia = area * area / 12;
  const double shear = young / 2;  // Poisson's ratio 0
  return std::pow(length, 3) / (3 * young * inertia) + length / (5. / 6 * shear * area);
}

StressTrial JudgeCompliance(const StressAnswer& answer, double truth, StressModel model,
                            double degraded_from, double failed_from) {
  const double ratio = answer.compliance / truth;
  StressTrial trial = Judge(std::abs(ratio - 1), degraded_from, failed_from);
  if (!std::isfinite(ratio)) {
    trial.error.reset();
    trial.how = "not finite";
    if (IsOurs(model)) trial.harm = trial.how;
  } else if (trial.fate != StressFate::kSurvived) {
    trial.how = Format("%.3g of the deflection", ratio);
  }
  return trial;
}

}  // namespace

StressCase BernsteinDegree(bool quick) {
  StressCase stress_case;
  stress_case.name = "bernstein_degree";
  stress_case.title = "Cantilever 1 : 10 bent, Bernstein lattice of degree (d, 2, 2)";
  stress_case.truth =
      "Timoshenko's beam, deflection of the end; degraded from 5 %, failed from 20 %";
  stress_case.parameter = {"degree", "", 6, 20, quick ? 20. : 30.};
  stress_case.models = {StressModel::kStrainSmall};
  stress_case.run = [](StressModel model, double degree) {
    StressBlockFixture beam = Cantilever(0.2, 0.02);
    beam.organ.lattice.basis = BasisType::kBernstein;
    beam.organ.lattice.cells = {1, 1, 1};
    beam.organ.lattice.degree = {Whole(degree), 2, 2};
    return JudgeCompliance(Rest(beam, model), BeamCompliance(0.2, 0.02, 5000), model, 0.05, 0.2);
  };
  return stress_case;
}

StressCase LatticeAspect(bool /*quick*/) {
  StressCase stress_case;
  stress_case.name = "lattice_aspect";
  stress_case.title =
      "Cantilever bent, lattice of 12 x 2 x 2 cells (tetrahedra: 60 x 7 x 7 bricks)";
  stress_case.truth =
      "Timoshenko's beam, deflection of the end; degraded from 10 %, failed from 40 %";
  stress_case.parameter = {"length over thickness", "", 5, 50, 500, true};
  stress_case.models = kAllModels;
  stress_case.run = [](StressModel model, double aspect) {
    const double thickness = 0.2 / aspect;
    return JudgeCompliance(Rest(Cantilever(0.2, thickness), model),
                           BeamCompliance(0.2, thickness, 5000), model, 0.1, 0.4);
  };
  return stress_case;
}

StressCase LatticeRefinement(bool /*quick*/) {
  StressCase stress_case;
  stress_case.name = "cells";
  stress_case.title = "Block pressed, cells (tetrahedra: bricks) along its 100 mm";
  stress_case.truth =
      "quadratic tetrahedra, surface displacement; degraded from 15 %, failed from 40 %";
  stress_case.parameter = {"cells", "", 10, 5, 1};
  stress_case.models = {StressModel::kStrainSmall, StressModel::kStrainFinite,
                        StressModel::kLinearTetrahedra};
  const StressBlockFixture block = PressedBlock(true);
  const auto truth = std::make_shared<Remembered>(
      [block](double) { return QuadraticRest(block, block.bricks).displacements; });
  stress_case.run = [block, truth](StressModel model, double cells) {
    StressBlockFixture refined = block;
    const int n = std::max(1, Whole(cells)), high = std::max(1, Whole(0.6 * cells));
    refined.bricks = refined.organ.lattice.cells = {n, n, high};
    return JudgeAnswer(BoxSurface(block.min, block.max, block.squares), Rest(refined, model),
                       truth->At(0), model, 0.15, 0.4);
  };
  return stress_case;
}

StressCase SurfaceRefinement(bool quick) {
  StressCase stress_case;
  const int finest = quick ? 20 : 30;
  stress_case.name = "triangles";
  stress_case.title = "Block pressed, surface squares (tetrahedra: bricks) along its 100 mm";
  stress_case.truth = Format(
      "the same model in %d squares, compliance; degraded from 5 %%, failed from 20 %%", finest);
  stress_case.parameter = {"squares", "", 0.5 * finest, 5, 2};
  stress_case.models = kAllModels;
  std::map<StressModel, double> converged;
  stress_case.run = [finest, converged](StressModel model, double squares) mutable {
    const auto compliance = [model](int n) {
      StressBlockFixture block = PressedBlock(true);
      block.squares = block.bricks = {n, n, std::max(1, Whole(0.6 * n))};
      return Rest(block, model);
    };
    if (!converged.contains(model)) converged[model] = compliance(finest).compliance;
    return JudgeCompliance(compliance(Whole(squares)), converged[model], model, 0.05, 0.2);
  };
  return stress_case;
}

}  // namespace hpdm
