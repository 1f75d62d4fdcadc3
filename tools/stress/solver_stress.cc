#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>

#include "engine/baselines/skin.h"
#include "engine/organ.h"
#include "engine/solver/maxwell_memory.h"
#include "tools/shared/report_text.h"
#include "tools/stress/material_cases.h"
#include "tools/stress/stress_block_fixture.h"

namespace hpdm {
namespace {

/// The block pressed by a grasp of its top patch, which moves `depth` (m) down in one step.
class BlockHeldAtPatch {
 public:
  BlockHeldAtPatch(const OrganOptions& organ, const StressBlockFixture& block, double depth)
      : block_(block),
        depth_(depth),
        organ_(organ, BoxSurface(block.min, block.max, block.squares)),
        contacts_(organ_.control_points()),
        U_(Points::Zero(organ_.control_points(), 3)) {}

  const OrganModel& organ() const { return organ_; }

  /// Makes one step. Returns the force on the tissue, N.
  RelaxationResult Step(double dt, bool held, Relaxation* relaxation, MaxwellMemory* memory) {
    contacts_.Clear();
    if (held) {
      ContactConstraints::Row* row = contacts_.Add();
      row->kind = ContactConstraints::RowKind::kGrasp;
      row->p_rest_W = block_.loads[0].p_centre_W;
      row->target_W = row->p_rest_W - Vector3d(0, 0, depth_);
      organ_.AddLoadToRow(row->p_rest_W, block_.loads[0].radius, contacts_.refinement,
                          contacts_.WeightRow(0));
    }
    return memory->Relax(dt, relaxation, &contacts_, &U_);
  }
  double Force() const { return -contacts_[0].force_W.z(); }
  const Points& U() const { return U_; }

 private:
  const StressBlockFixture& block_;
  double depth_;
  OrganModel organ_;
  ContactConstraints contacts_;
  Points U_;
};

StressTrial JudgeOurs(double error, double degraded_from, double failed_from) {
  StressTrial trial = Judge(error, degraded_from, failed_from);
  if (!std::isfinite(error)) {
    trial.error.reset();
    trial.harm = trial.how = "not finite";
  }
  return trial;
}

/// Returns the displacements (m) of a block that is held for half a second, in steps of `dt` (s).
/// `explicit_euler`: springs with one explicit step a step.
Points HeldShape(StressBlockFixture block, double dt, bool explicit_euler) {
  block.organ.time_step = dt;
  BlockHeldAtPatch body(block.organ, block, 0.006);
  MaxwellMemory none({}, body.organ().control_points());
  std::unique_ptr<Relaxation> relaxation = body.organ().MakeRelaxation(0);
  if (explicit_euler) {
    const SurfaceMesh& rest = body.organ().rest();
    const Skin skin = MeasureSkin(rest, block.organ.name);
    MassSpringOptions springs = MassSpringOf(block.organ.material, skin.thickness, dt);
    springs.substeps = 1;
    relaxation =
        std::make_unique<MassSpring>(rest,
                                     GroundSprings(rest, skin, block.organ.supports,
                                                   block.organ.material.young, block.organ.name),
                                     springs, block.organ.name);
  }
  for (double t = 0; t < 0.5 - dt / 2; t += dt) body.Step(dt, true, relaxation.get(), &none);
  return body.U();
}

// Returns the share of the shape that is left after `hold` (s) of holding and as long a recovery, of a
// solid with one Maxwell branch. Load and release each take one step of `dt` (s), in which the shape
// changes linearly: the branch's strain W obeys dW/dt = dU/dt - W / time.
double ShareLeft(double dt, double hold, double share, double time) {
  const double ratio = share / (1 - share), decay = std::exp(-dt / time);
  const double gain = time / dt * (1 - decay);
  const double held_strain = gain * std::exp(-(hold - dt) / time);
  const double released = ratio * (gain - held_strain * decay) / (1 + ratio * gain);
  return released * std::exp(-(hold - dt) * (1 - share) / time);
}

}  // namespace

StressCase GaussSeidelSweeps(bool quick) {
  StressCase stress_case;
  stress_case.name = "gauss_seidel";
  stress_case.title = "Block pressed 6 mm at Poisson's ratio 0.49, solved by Gauss-Seidel";
  stress_case.truth =
      "Cholesky's answer, displacement of the control points; degraded from 1 %, failed from 10 %";
  stress_case.parameter = {"sweeps", "", 50000, 2000, 10, true};
  stress_case.models = {StressModel::kStrainSmall, StressModel::kMetricSmall};
  stress_case.run = [quick](StressModel model, double sweeps) {
    StressBlockFixture block = PressedBlock(quick);
    block.organ.material.poisson = 0.49;
    Choose(model, &block.organ);
    BlockHeldAtPatch exact(block.organ, block, 0.006), swept(block.organ, block, 0.006);
    const int n = exact.organ().control_points();
    MaxwellMemory none({}, n), none_either({}, n);
    exact.Step(0, true, exact.organ().MakeRelaxation(0).get(), &none);
    const std::unique_ptr<Relaxation> gauss_seidel = std::visit(
        [sweeps](const auto& K) {
          return MakeGaussSeidelRelaxation(K, {.max_sweeps = Whole(sweeps), .tolerance = 1e-6});
        },
        exact.organ().stiffness());
    const RelaxationResult result = swept.Step(0, true, gauss_seidel.get(), &none_either);
    StressTrial trial = JudgeOurs((swept.U() - exact.U()).norm() / exact.U().norm(), 0.01, 0.1);
    trial.how = Format("residual %.1g after %d sweeps", result.residual, result.iterations);
    return trial;
  };
  return stress_case;
}

StressCase NewtonIterations(bool quick) {
  StressCase stress_case;
  stress_case.name = "newton_iterations";
  stress_case.title = "Block pressed 20 mm of its 60 in one step, held for ten steps";
  stress_case.truth = "the force after 100 iterations a step; degraded from 1 %, failed from 10 %";
  stress_case.parameter = {"iterations a step", "", 20, 3, 1};
  stress_case.models = {StressModel::kStrainFinite, StressModel::kMetricFinite};
  std::map<StressModel, double> converged;
  stress_case.run = [quick, converged](StressModel model, double iterations) mutable {
    const auto force = [quick, model](int most) {
      StressBlockFixture block = PressedBlock(quick);
      Choose(model, &block.organ);
      if (model == StressModel::kMetricFinite) block.organ.energy.alpha /= 4;
      block.organ.energy.newton_iterations = most;
      BlockHeldAtPatch held(block.organ, block, 0.02);
      MaxwellMemory none({}, held.organ().control_points());
      const std::unique_ptr<Relaxation> newton = held.organ().MakeRelaxation(0);
      for (int step = 0; step < 10; ++step) held.Step(0, true, newton.get(), &none);
      return held.Force();
    };
    if (!converged.contains(model)) converged[model] = force(100);
    return JudgeOurs(std::abs(force(Whole(iterations)) / converged[model] - 1), 0.01, 0.1);
  };
  return stress_case;
}

StressCase TimeStep(bool /*quick*/) {
  StressCase stress_case;
  stress_case.name = "time_step";
  stress_case.title = "Block pressed 6 mm for half a second and released, in steps of equal length";
  stress_case.truth =
      "lattices: 13.1 % of the shape is left after 0.5 s of recovery, a little more with long "
      "steps, "
      "in which load and release are ramps (half of the modulus relaxes in 0.2 s); "
      "surface models (springs with one explicit step a step): the shape held by short steps; "
      "degraded from 5 %, failed from 50 %";
  stress_case.parameter = {"step", "ms", 0.2, 1000. / 30, 500, true};
  stress_case.models = {StressModel::kStrainSmall, StressModel::kStrainFinite,
                        StressModel::kMetricSmall, StressModel::kMetricFinite,
                        StressModel::kContinuum,   StressModel::kMassSpring};
  std::map<StressModel, Points> held_shape;
  stress_case.run = [held_shape](StressModel model, double step_ms) mutable {
    StressBlockFixture block = PressedBlock(true);
    block.squares = {10, 10, 6};
    Choose(model, &block.organ);
    const int steps = std::max(1, Whole(500 / step_ms));
    const double dt = 0.5 / steps;
    if (IsOurs(model)) {
      constexpr double kShare = 0.5, kTime = 0.2;
      BlockHeldAtPatch body(block.organ, block, 0.006);
      MaxwellMemory memory({.count = 1, .terms = {{{.share = kShare, .time = kTime}}}},
                           body.organ().control_points());
      const std::unique_ptr<Relaxation> relaxation = body.organ().MakeRelaxation(0);
      for (int s = 0; s < steps; ++s) body.Step(dt, true, relaxation.get(), &memory);
      const Points held = body.U();
      for (int s = 0; s < steps; ++s) body.Step(dt, false, relaxation.get(), &memory);
      const Points left = ShareLeft(dt, 0.5, kShare, kTime) * held;
      return JudgeOurs((body.U() - left).norm() / left.norm(), 0.05, 0.5);
    }
    if (!held_shape.contains(model)) held_shape[model] = HeldShape(block, 1e-3, false);
    const Points& truth = held_shape[model];
    const Points at = HeldShape(block, dt, model == StressModel::kMassSpring);
    StressTrial trial = Judge((at - truth).norm() / truth.norm(), 0.05, 0.5);
    if (!at.allFinite() || at.cwiseAbs().maxCoeff() > 1) {
      trial.error.reset();
      trial.how = "explodes";
    }
    return trial;
  };
  return stress_case;
}

}  // namespace hpdm
