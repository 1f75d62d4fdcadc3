#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <utility>

#include "engine/baselines/surface_error.h"
#include "tools/shared/report_text.h"
#include "tools/stress/motion_block.h"
#include "tools/stress/stress_cases.h"

namespace hpdm {
namespace {

constexpr double kReleased = kBlockStart + 0.5;  // s
constexpr double kAtTop = 0.0025;                // m: a tip at this height touches the top

StressCase MotionCase(std::string name, std::string title, StressParameter parameter) {
  StressCase stress_case;
  stress_case.name = std::move(name);
  stress_case.group = "motion";
  stress_case.title = std::move(title);
  stress_case.truth = kVolumeTruth;
  stress_case.parameter = std::move(parameter);
  stress_case.models = BlockModels();
  return stress_case;
}

// Makes the case of one tool on the block; `tool_at` makes the tool from the parameter's value.
StressCase OneTool(StressCase stress_case, bool quick, std::function<StressTool(double)> tool_at) {
  stress_case.run = [quick, tool_at = std::move(tool_at)](StressModel model, double value) {
    StressSessionFixture body(BlockOrgan(model, quick), BlockSurface(quick), {tool_at(value)});
    return JudgeMotion(&body, kReleased);
  };
  return stress_case;
}

StressCase PressDeep(bool quick) {
  return OneTool(
      MotionCase("press_deep",
                 "A ball of 20 mm pressed into 100 mm of tissue until it inverts, then withdrawn",
                 {"depth over thickness", "%", 5, 50, 110}),
      quick, [](double share) { return BlockBall(share / 100 * kBlockThickness, 0.2, kReleased); });
}

StressCase Poke(bool quick) {
  return OneTool(
      MotionCase("poke_in_one_step",
                 "A ball of 20 mm through 100 mm of tissue within a step, then withdrawn",
                 {"depth", "mm", 5, 100, 115}),
      quick, [](double depth) { return BlockBall(depth / 1e3, 0, kReleased); });
}

StressCase LiftFar(bool quick) {
  return OneTool(
      MotionCase("lift_far", "Grasped at the top, lifted and let go", {"lift", "mm", 5, 100, 300}),
      quick, [](double lift) {
        return BlockGrasp(0, AtBlock(0, kAtTop + lift / 1e3, 0), 0.2, kReleased);
      });
}

StressCase PullThrough(bool quick) {
  return OneTool(
      MotionCase("grasp_through_itself",
                 "Grasped at the top, pulled down through itself within a step and let go",
                 {"way", "mm", 5, 90, 95}),
      quick,
      [](double way) { return BlockGrasp(0, AtBlock(0, kAtTop - way / 1e3, 0), 0, kReleased); });
}

// Returns where the tissue that the tool holds must be, by the tool's turn alone: its displacements
// from rest, m. `held`: H x 3, m, at rest.
Points TurnedWithTool(const StressTool& tool, double until, const Points& held) {
  const Isometry3d turn = ToolFrame(tool, until) * ToolFrame(tool, kBlockStart).inverse();
  Points ways(held.rows(), 3);
  for (Eigen::Index i = 0; i < held.rows(); ++i) {
    const Vector3d p_W = held.row(i);
    ways.row(i) = turn * p_W - p_W;
  }
  return ways;
}

// Judges a twist by the organ's shape. At 540 degrees the jaws stand half a turn from rest; at 360
// or 720 they would stand as at rest, where any model is right.
StressTrial TwistShape(StressModel model, double degrees, bool quick) {
  const double angle = degrees * std::numbers::pi / 180;
  const StressTool tool = BlockGrasp(0, AtBlock(0, kAtTop, 0, angle), 0.2, kReleased);
  StressSessionFixture body(BlockOrgan(model, quick), BlockSurface(quick), {tool});
  body.RunUntil(kReleased);
  const ContactConstraints& rows = body.state().contacts;
  StressTrial trial;
  if (rows.size() == 0) {
    trial.fate = StressFate::kFailed;
    trial.how = "holds nothing";
    return trial;
  }
  Points held(rows.size(), 3), moved(rows.size(), 3);
  for (int i = 0; i < rows.size(); ++i) {
    held.row(i) = rows[i].p_rest_W;
    moved.row(i) = rows.Weights().row(i) * body.state().control_displacements;
  }
  const Points ways = TurnedWithTool(tool, kReleased - 1e-3, held);
  const Points shape = Displacements(body);
  const double volume = std::abs(RelativeVolumeChange(body.organ().rest(), shape));
  const double missed = (moved - ways).norm() / ways.norm();
  double error = std::max(volume, missed);
  std::string how = missed == error ? Format("jaws' tissue off by %.2g %%", 100 * missed) : "";
  if (model == StressModel::kStrainSmall) {
    const Points truth = HeldBlock(body.organ().options(), quick, held, ways);
    const double off = RelativeSurfaceError(body.organ().rest(), shape, truth);
    how = off > error ? Format("shape off by %.2g %%", 100 * off) : how;
    error = std::max(error, off);
  }
  trial = Judge(error, kVolumeDegraded, kVolumeFailed);
  if (trial.fate != StressFate::kSurvived) trial.how = how;
  AddReturn(&body, kReleased, &trial);
  return trial;
}

StressCase Twist(bool quick) {
  StressCase stress_case =
      MotionCase("twist", "Grasped at the top, twisted about the shaft and let go",
                 {"angle", "deg", 5, 540, 540});
  stress_case.truth =
      "the largest of: the held tissue against the tool's own turn; the volume against that at "
      "rest; in small strain, the whole surface against quadratic tetrahedra with the same points "
      "held. Degraded from 10 %, if inverted or left behind; failed from 50 %, or if 0.1 mm stay a "
      "second after release";
  stress_case.run = [quick](StressModel model, double degrees) {
    return TwistShape(model, degrees, quick);
  };
  return stress_case;
}

// Grasps and lifts by 15 mm with steps of `ms`. Returns the shape at the end of the hold.
Points LiftedWithSteps(StressModel model, double ms, bool quick, StressTrial* trial) {
  constexpr double kClosed = 2, kLifts = 3.2, kLifted = 3.4, kEnd = 5.5;  // s
  TimingOptions timing;
  timing.deformation_hz = std::max(1, static_cast<int>(std::lround(1000 / ms)));
  timing.patch_delay_ticks = (timing.haptic_hz + timing.deformation_hz - 1) / timing.deformation_hz;
  OrganOptions options = BlockOrgan(model, quick);
  options.time_step = 1. / timing.deformation_hz;
  const StressPose open = AtBlock(0, kAtTop), closed = AtBlock(0, kAtTop, 0);
  const StressPose lifted = AtBlock(0, kAtTop + 0.015, 0);
  StressSessionFixture body(options, BlockSurface(quick),
                            {BlockHand({{0, open},
                                        {kClosed, open},
                                        {kClosed + 0.05, closed},
                                        {kLifts, closed},
                                        {kLifted, lifted},
                                        {kEnd, lifted},
                                        {kEnd, AtBlock(0, 0.03)}})},
                            timing);
  body.RunUntil(kEnd);
  const Points shape = Displacements(body);
  if (trial != nullptr) {
    body.RunUntil(kEnd + 2 * options.time_step);
    AddReturn(&body, kEnd + options.time_step, trial);
  }
  return shape;
}

StressCase StretchedStep(bool quick) {
  StressCase stress_case =
      MotionCase("stretched_step", "Grasped and lifted by 15 mm with long deformation steps",
                 {"step", "ms", 33, 500, 1000});
  const double least = quick ? 20 : 1;
  stress_case.truth = Format(
      "the surface after 2 s against that with steps of %.0f ms: degraded from 1 %%, failed "
      "from 10 %%, or if 0.1 mm stay a second after release",
      least);
  stress_case.run = [quick, least, shapes = std::make_shared<std::map<StressModel, Points>>()](
                        StressModel model, double ms) {
    const auto known = shapes->find(model);
    const Points truth = known != shapes->end()
                             ? known->second
                             : (*shapes)[model] = LiftedWithSteps(model, least, quick, nullptr);
    StressTrial after;
    const Points shape = LiftedWithSteps(model, ms, quick, &after);
    StressTrial trial = Judge(RelativeSurfaceError(BlockSurface(quick), shape, truth), 0.01, 0.1);
    trial.fate = std::max(trial.fate, after.fate);
    trial.how = after.how;
    trial.harm = after.harm;
    return trial;
  };
  return stress_case;
}

// Runs Newton's method on a displacement that happens within one step and is then held.
StressCase NewtonHeld(bool quick) {
  StressCase stress_case =
      MotionCase("newton_residual", "Grasped, pulled aside within a step and held: Newton's method",
                 {"way", "mm", 5, 30, 200});
  stress_case.truth =
      "residual of the equilibrium over the load, a second later: degraded from 1e-5 (the "
      "tolerance is 1e-6), failed from 1 %, or if it grows tenfold in the last half second";
  stress_case.models = {StressModel::kStrainFinite, StressModel::kMetricFinite};
  stress_case.run = [quick](StressModel model, double way) {
    constexpr double kHeld = kBlockStart + 1.1;
    StressSessionFixture body(BlockOrgan(model, quick), BlockSurface(quick),
                              {BlockGrasp(0, AtBlock(way / 1e3, kAtTop, 0), 0, kHeld)});
    double least = 1e300, most = 0;
    for (double t = kBlockStart + 0.1; t <= kHeld; t += 1. / 30) {
      body.RunUntil(t);
      const double residual = body.step().step.residual;
      if ((body.step().step.flags & kStepRecovering) != 0) continue;  // converges by load steps
      const bool early = t < kBlockStart + 0.6;
      (early ? least : most) = early ? std::min(least, residual) : std::max(most, residual);
    }
    StressTrial trial = Judge(body.step().step.residual, 1e-5, 0.01);
    AddReturn(&body, kHeld, &trial);
    if (most > 1e-5 && most > 10 * least) {
      trial.fate = StressFate::kFailed;
      trial.how = "the residual grows";
    }
    return trial;
  };
  return stress_case;
}

// Measures the position of viscoelastic tissue half a second after its release.
StressCase Viscous(bool quick) {
  StressCase stress_case = MotionCase(
      "viscous", "Viscoelastic tissue grasped, pulled down by 10 mm within a step and let go",
      {"relaxation time", "s", 0.01, 1, 100, true});
  stress_case.truth =
      "exp(-0.25 s / relaxation time) of the displacement 0.5 s after release, half of the "
      "modulus relaxes: relative error; "
      "degraded from 1 % or if inverted or left behind, failed from 10 %, or if any vertex ever "
      "moves twice the distance";
  stress_case.models = LatticeModels();
  stress_case.run = [quick](StressModel model, double relaxation_time) {
    constexpr double kWay = 0.01;  // m
    OrganOptions options = BlockOrgan(model, quick);
    constexpr double kShare = 0.5;
    options.material.prony = {.count = 1, .terms = {{{.share = kShare, .time = relaxation_time}}}};
    StressSessionFixture body(options, BlockSurface(quick),
                              {BlockGrasp(0, AtBlock(0, kAtTop - kWay, 0), 0, kReleased)});
    body.RunUntil(kReleased + 0.1);
    const Points before = Displacements(body);
    const double from = ToSeconds(body.step().step.time_ns);
    body.RunUntil(kReleased + 0.6);
    const double elapsed = ToSeconds(body.step().step.time_ns) - from;
    const Points expected = std::exp(-elapsed * (1 - kShare) / relaxation_time) * before;
    const double size = std::max(before.norm(), 1e-9);
    StressTrial trial = Judge((Displacements(body) - expected).norm() / size, 0.01, 0.1);
    const StressOutcome& outcome = body.outcome();
    if (outcome.largest_displacement > 2 * kWay) {
      trial.fate = StressFate::kFailed;
      trial.how = Format("%.2g mm away", 1e3 * outcome.largest_displacement);
    } else if (outcome.inverted_share > 0 || (outcome.flags & kStepRecovering) != 0) {
      trial.fate = std::max(trial.fate, StressFate::kDegraded);
      trial.how = outcome.inverted_share > 0
                      ? Format("%.2g %% inverted", 100 * outcome.inverted_share)
                      : "left behind";
    }
    AddFaults(outcome, std::numeric_limits<double>::infinity(), &trial);
    return trial;
  };
  return stress_case;
}

}  // namespace

std::vector<StressCase> MotionStress(bool quick) {
  return {PressDeep(quick), Poke(quick),          LiftFar(quick),    PullThrough(quick),
          Twist(quick),     StretchedStep(quick), NewtonHeld(quick), Viscous(quick)};
}

}  // namespace hpdm
