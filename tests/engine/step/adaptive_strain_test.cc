// The effect of a step's quality on the forces of presses and lifts (strain_blend_controller.h,
// load_shedding.h).

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <functional>

#include "engine/deformation_loop.h"
#include "tests/support/shapes.h"
#include "tools/shared/one_organ.h"

namespace hpdm {
namespace {

constexpr Nanoseconds kPeriod = kNanosecondsPerSecond / 30;
constexpr int kSteps = 60;         // of a ramp up or down: 2 s
constexpr double kRadius = 0.012;  // m: a blunt probe, whose presses the lattice resolves

OrganOptions Options(StrainMeasure strain, int functions = 0) {
  OrganOptions options;
  options.name = "ellipsoid";
  options.energy.type = EnergyType::kStrain;
  options.energy.strain = strain;
  options.energy.newton_budget = 0;
  options.energy.finite_from = 0.15;
  options.lattice.cells = {2, 2, 2};
  options.lattice.local.functions = functions;
  options.supports = {{BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.25)}, {}}};
  return options;
}

struct Bench {
  explicit Bench(const std::vector<OrganModel>& organs,
                 std::function<Nanoseconds()> stopwatch = nullptr, Nanoseconds budget = 0)
      : render(SizedSnapshot(organs, 1, false)),
        telemetry(SizedSnapshot(organs, 1, false)),
        loop(organs, {ToolOptions{.geometries = {{.tip_radius = kRadius, .can_grasp = true}}}},
             {tools, patch, render, telemetry, &steps}, std::move(stopwatch), budget) {}

  // `height` (m) of the tip's centre above the top.
  const ToolPatch& Step(double height, bool grasps) {
    ToolState state;
    state.tick = ++count;
    state.tool_count = 1;
    ToolPose& tool = state.tools[0];
    tool.jaw = grasps && count > 1 ? 0 : 1;
    tool.X_WT.translation() = Vector3d(0, 0, 0.05 + height);
    tool.p_trocar_W = Vector3d(0, 0, 0.3);
    loop.Step(state, static_cast<Nanoseconds>(count) * kPeriod);
    EXPECT_TRUE(steps.Pop(&sample));
    patch.Update();
    return patch.Front().tools[0].main();
  }
  double share() const { return sample.organs[0].finite_strain_blend; }

  TripleBuffer<ToolState> tools;
  TripleBuffer<ContactPatch> patch;
  TripleBuffer<SceneSnapshot> render, telemetry;
  SpscQueue<StepSample> steps{4};
  DeformationLoop loop;
  StepSample sample;
  std::uint64_t count = 0;
};

struct Ramp {
  const char* name;
  bool grasps;
  double from, to;  // m, of the tip's centre above the top
  int functions;
};

void PrintTo(const Ramp& ramp, std::ostream* out) { *out << ramp.name; }

class AdaptiveStrain : public testing::TestWithParam<Ramp> {
 protected:
  double Height(int step) const {
    const double along = 1 - std::abs(static_cast<double>(step - kSteps)) / kSteps;
    return GetParam().from + along * (GetParam().to - GetParam().from);
  }
  std::vector<OrganModel> Organ(StrainMeasure strain) const {
    return OneOrgan(Options(strain, GetParam().functions), Ellipsoid(Vector3d(0.1, 0.07, 0.05), 2));
  }
};

TEST_P(AdaptiveStrain, ChangesStrainWithoutAForceStep) {
  const std::vector<OrganModel> small = Organ(StrainMeasure::kSmall),
                                finite = Organ(StrainMeasure::kFinite),
                                adaptive = Organ(StrainMeasure::kAdaptive);
  Bench pure_small(small), pure_finite(finite), bench(adaptive);
  Vector3d small_last = Vector3d::Zero(), finite_last = small_last, last = small_last;
  double largest = 0, share_last = 0;
  int small_steps = 0, finite_steps = 0;
  for (int step = 0; step <= 2 * kSteps; ++step) {
    const Vector3d f_small = pure_small.Step(Height(step), GetParam().grasps).force_on_tissue_W;
    const Vector3d f_finite = pure_finite.Step(Height(step), GetParam().grasps).force_on_tissue_W;
    const ToolPatch& patch = bench.Step(Height(step), GetParam().grasps);
    const Vector3d f = patch.force_on_tissue_W;
    const double share = bench.share();
    small_steps += share == 0;
    finite_steps += share == 1;
    if (share == 0) {
      // The place of the contact comes from the surface after the last step, and adaptive strain
      // leaves out local functions with little tissue (0.3 % of the force).
      EXPECT_LT((f - f_small).norm(), 4e-3 * f_small.norm() + 1e-9) << step;
    } else if (share == 1 && share_last == 1 && f.norm() > 0.01) {
      // Iterations end at a residual of 1e-3, from different starts. With local functions the two
      // differ by up to 0.8 % on the way back.
      const double differs = GetParam().functions > 0 ? 1e-2 : 2e-3;
      EXPECT_LT((f - f_finite).norm(), differs * f_finite.norm()) << step;
    }
    if (patch.reaction == ReactionType::kLattice && patch.organ >= 0 && f.norm() > 0.01) {
      // The tick continues from this step's force for any blend.
      const Vector3d felt = patch.compliance_W.inverse() * (patch.contact_W - patch.p_original_W);
      EXPECT_LT((felt - f).norm(), 1e-6 * f.norm()) << step;
    }
    // The part that the change of strain adds to the tool's own step.
    const Vector3d own = (1 - share) * (f_small - small_last) + share * (f_finite - finite_last);
    if (step > 2 && share != share_last && f.norm() > 0.01) {
      largest = std::max(largest, (f - last - own).norm() / f.norm());
    }
    small_last = f_small;
    finite_last = f_finite;
    last = f;
    share_last = share;
  }
  EXPECT_GT(small_steps, 5);
  EXPECT_GT(finite_steps, 0);
  // At most StrainBlendController::kMaxForceStep, where the tool runs ahead; else a quarter of
  // that.
  EXPECT_LE(largest, GetParam().grasps ? 0.02 : 0.005) << "of the force";
}

TEST_P(AdaptiveStrain, IsTheSameEachTime) {
  const std::vector<OrganModel> organ = Organ(StrainMeasure::kAdaptive);
  Bench first(organ), second(organ);
  for (int step = 0; step <= kSteps; step += 4) {
    first.Step(Height(step), GetParam().grasps);
    second.Step(Height(step), GetParam().grasps);
    ASSERT_EQ(first.loop.organ(0).vertices, second.loop.organ(0).vertices) << step;
  }
}

TEST(AdaptiveStrainLoop, ANewTouchBeginsInSmallStrain) {
  const std::vector<OrganModel> organ =
      OneOrgan(Options(StrainMeasure::kAdaptive), Ellipsoid(Vector3d(0.1, 0.07, 0.05), 2));
  Bench bench(organ);
  for (int step = 0; step < 30; ++step) bench.Step(kRadius - 0.001 * step, false);
  EXPECT_GT(bench.share(), 0);
  bench.Step(kRadius + 0.01, false);
  for (int step = 0; step < 6; ++step) {
    bench.Step(kRadius - 0.002, false);
    EXPECT_EQ(bench.share(), 0) << step;
  }
}

INSTANTIATE_TEST_SUITE_P(Ramps, AdaptiveStrain,
                         testing::Values(Ramp{"press", false, kRadius, kRadius - 0.03, 0},
                                         Ramp{"press_refined", false, kRadius, kRadius - 0.03, 12},
                                         Ramp{"lift", true, kRadius, 0.04, 0},
                                         Ramp{"lift_refined", true, kRadius, 0.04, 12}),
                         [](const auto& ramp) { return std::string(ramp.param.name); });

// A machine on which finite strain takes four times the budget, and a loop that replays its log.
TEST(Shedding, IsGradualReportedAndAppliedByAReplay) {
  OrganOptions options = Options(StrainMeasure::kFinite);
  options.energy.newton_iterations = 6;
  const std::vector<OrganModel> organ = OneOrgan(options, Ellipsoid(Vector3d(0.1, 0.07, 0.05), 2));
  constexpr Nanoseconds kBudget = 20'000'000;
  Nanoseconds now = 0;
  bool busy = false, ends = false;
  // Read when a step begins and when its patch is built, and by Newton's method between them.
  Bench* running = nullptr;
  const auto stopwatch = [&] {
    const bool finite =
        running != nullptr && running->loop.organ(0).quality.finite_strain_blend > 0;
    now += busy && finite ? kBudget : 1'000'000;
    return now;
  };
  Bench live(organ, stopwatch, kBudget), replay(organ);
  running = &live;
  double last = 0, largest = 0;
  int deepest = 0;
  for (int step = 0; step < 330; ++step) {
    busy = step > 30 && step < 120;
    const double height = kRadius - 0.015 * std::min(1.0, step / 20.0);
    const double f = live.Step(height, false).force_on_tissue_W.norm();
    if (step > 30) largest = std::max(largest, std::abs(f - last) / f);
    last = f;
    deepest = std::max(deepest, live.sample.step.shed_level);
    EXPECT_EQ((live.sample.step.flags & kStepShed) != 0, live.sample.step.shed_level > 0);
    replay.loop.ApplyRecorded(live.sample);
    const double again = replay.Step(height, false).force_on_tissue_W.norm();
    ASSERT_EQ(f, again) << step;
    ASSERT_EQ(live.loop.organ(0).vertices, replay.loop.organ(0).vertices) << step;
    ASSERT_EQ(live.sample.step.flags, replay.sample.step.flags) << step;
    ASSERT_EQ(live.sample.step.shed_level, replay.sample.step.shed_level) << step;
    ends = live.sample.step.shed_level == 0 && live.share() == 1;
  }
  EXPECT_EQ(deepest, 2) << "without finite strain there is time";
  EXPECT_TRUE(ends) << "all is back";
  EXPECT_LE(largest, 0.02) << "of the force, while the tool stands still";
}

}  // namespace
}  // namespace hpdm
