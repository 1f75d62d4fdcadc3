#include <algorithm>
#include <cmath>

#include "engine/baselines/surface_error.h"
#include "engine/organ/organ_state.h"
#include "tools/stress/material_cases.h"
#include "tools/stress/stress_block_fixture.h"

namespace hpdm {
namespace {

// Returns the block with its lengths times `length` and its stiffness times `modulus`. The loads
// give the same shape.
StressBlockFixture Scaled(double length, double modulus) {
  StressBlockFixture block = PressedBlock(true);
  block.min *= length;
  block.max *= length;
  block.squares = {10, 10, 6};
  block.bricks = {6, 6, 4};
  block.organ.lattice.margin *= length;
  block.organ.lattice.cells = {3, 3, 2};
  block.organ.material.young *= modulus;
  block.organ.energy.alpha *= modulus;
  block.organ.energy.beta = 0.02 * modulus * length * length;
  block.loads[0].p_centre_W *= length;
  block.loads[0].radius *= length;
  block.loads[0].force_W = *block.loads[0].force_W * modulus * length * length * 10;
  return block;
}

// Returns the relaxed surface when a tip presses a tenth of its height deep.
Points Pressed(const StressBlockFixture& block, StressModel model, SolverType solver) {
  OrganOptions options = block.organ;
  Choose(model, &options);
  options.energy.solver = solver;
  const OrganModel organ(options, BoxSurface(block.min, block.max, block.squares));
  OrganState state(organ, 1);
  for (int step = 0; step < 3; ++step) {
    state.contacts.Clear();
    ContactConstraints::Row* row = state.contacts.Add();
    row->p_rest_W = block.loads[0].p_centre_W;
    row->target_W = row->p_rest_W - Vector3d(0, 0, block.max.z() / 10);
    row->indentation = organ.AddLoadToRow(row->p_rest_W, block.loads[0].radius,
                                          state.contacts.refinement, state.contacts.WeightRow(0));
    state.relaxation->Relax(&state.contacts, &state.control_displacements);
  }
  Points moved(organ.rest().vertices.rows(), 3);
  organ.relocation().Displace(state.control_displacements, &moved);
  return moved;
}

std::vector<Points> Shapes(const StressBlockFixture& block, StressModel model, double length) {
  std::vector<Points> shapes = {Rest(block, model).displacements / length};
  if (!IsOurs(model)) return shapes;
  shapes.push_back(Pressed(block, model, SolverType::kCholesky) / length);
  if (model == StressModel::kStrainSmall || model == StressModel::kMetricSmall) {
    shapes.push_back(Pressed(block, model, SolverType::kGaussSeidel) / length);
  }
  return shapes;
}

}  // namespace

StressCase Rescaled(bool quick) {
  StressCase stress_case;
  stress_case.name = "rescaled";
  stress_case.title =
      "Block in another unit: lengths scaled up and down, modulus by the scale's square";
  stress_case.truth =
      "the same shape (static, and by steps of each solver), surface displacement; degraded from "
      "1e-6, failed from 1e-3";
  stress_case.parameter = {"scale", "", 10, 1000, quick ? 1e3 : 1e6, true};
  stress_case.models = kAllModels;
  stress_case.run = [](StressModel model, double scale) {
    const StressBlockFixture block = Scaled(1, 1);
    const SurfaceMesh rest = BoxSurface(block.min, block.max, block.squares);
    const std::vector<Points> shapes = Shapes(block, model, 1);
    double error = 0;
    bool finite = true;
    for (const auto& [length, modulus] :
         {std::pair(scale, 1.), std::pair(1 / scale, 1.), std::pair(1., scale * scale),
          std::pair(1., 1 / (scale * scale))}) {
      const std::vector<Points> others = Shapes(Scaled(length, modulus), model, length);
      for (std::size_t s = 0; s < shapes.size(); ++s) {
        finite = finite && others[s].allFinite();
        error = std::max(error, RelativeSurfaceError(rest, others[s], shapes[s]));
      }
    }
    StressTrial trial = Judge(finite ? error : std::nan(""), 1e-6, 1e-3);
    if (!finite) {
      trial.error.reset();
      trial.how = "not finite";
      if (IsOurs(model)) trial.harm = trial.how;
    }
    return trial;
  };
  return stress_case;
}

}  // namespace hpdm
