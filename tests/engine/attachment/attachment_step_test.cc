// Attached organs in the deformation loop: tearing, what the hand feels, sleep and copies.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/support/bed_layer.h"
#include "tests/support/counted_allocations.h"
#include "tests/support/shapes.h"
#include "tools/shared/organ_bench.h"

namespace hpdm {
namespace {

constexpr double kHalfMotion = 1;  // s: then an organ's offset is its whole displacement

// A rigid plate below z = 0 and a block of `height` (m) on it, joined by a layer.
struct AttachedBlock {
  double young = 2e5;  // Pa
  double height = 0.01;
  Vector3d size = Vector3d(0.03, 0.03, 0);  // m, of the block in x and y
  std::array<int, 3> cells = {3, 3, 2};
  bool held = true;                            // at its top
  Vector3d motion_W = Vector3d::Zero();        // m, of the block's support
  Vector3d plate_motion_W = Vector3d::Zero();  // m
  double scale = 1;                            // of all lengths
  int functions = 0;

  AttachmentOptions Layer() const {
    AttachmentOptions layer = BedLayer(
        "block", "plate", hpdm::Box{Vector3d(-1, -1, -1), Vector3d(1, 1, 1)}, 0.001 * scale);
    layer.thickness *= scale;
    layer.toughness *= scale;
    return layer;
  }
  double Area() const { return scale * scale * size.x() * size.y(); }

  void AddTo(OrganBench* bench) const {
    OrganOptions plate;
    plate.name = "plate";
    plate.model = OrganModelType::kRigid;
    plate.motion = {scale * plate_motion_W, 0.5 / kHalfMotion};
    const Vector3d half = scale * size / 2;
    bench->Add(plate, GridBox(Vector3d(-0.06, -0.06, -0.01) * scale,
                              Vector3d(0.06, 0.06, 0) * scale, {24, 24, 2}));
    OrganOptions block;
    block.name = "block";
    block.material = {.young = young, .poisson = 0.3};
    block.lattice.cells = cells;
    block.lattice.margin = 0.0005 * scale;
    block.lattice.local.functions = functions;
    block.motion = {scale * motion_W, 0.5 / kHalfMotion};
    if (held) {
      block.supports.push_back(
          {hpdm::Box{Vector3d(-1, -1, 0.8 * height * scale), Vector3d(1, 1, 1)}, {}});
    }
    bench->Add(block, GridBox(Vector3d(-half.x(), -half.y(), 0.0003 * scale),
                              Vector3d(half.x(), half.y(), scale * height), {12, 12, 4}));
    bench->Attach(Layer());
  }
};

void StartWithGrasper(OrganBench* bench) {
  ToolOptions grasper;
  grasper.geometries[0].can_grasp = true;
  bench->Start({grasper});
}

// Jaws that close on a block of `height` (m) in the third step and lift it by 0.3 mm a step.
ToolPose GraspAndLift(double height, int step) {
  ToolPose tool = OrganBench::Above(Vector3d(0.01, 0, height + 0.0023));
  tool.jaw = step < 2 ? 1 : 0.05;
  tool.X_WT.translation().z() += 0.0003 * std::max(0, step - 1);
  return tool;
}

const AttachmentOutcome& OutcomeOf(const OrganBench& bench) {
  return bench.loop().links()[0].outcomes()[0];
}

std::vector<double> DamageOf(const OrganBench& bench) {
  const auto damage = bench.loop().links()[0].state().damage();
  return {damage.begin(), damage.end()};
}

struct PullCase {
  std::string name;
  Vector3d way;  // m
  int steps;     // for half a period
  double scale;
};
class PulledOff : public testing::TestWithParam<PullCase> {};

INSTANTIATE_TEST_SUITE_P(Cases, PulledOff,
                         testing::Values(PullCase{"apart", Vector3d(0, 0, 0.012), 240, 1},
                                         PullCase{"apart_in_few_steps", Vector3d(0, 0, 0.012), 60,
                                                  1},
                                         PullCase{"across", Vector3d(0.012, 0.003, 0), 240, 1},
                                         PullCase{"both", Vector3d(0.007, 0, 0.009), 240, 1},
                                         PullCase{"larger", Vector3d(0.007, 0, 0.009), 240, 3}),
                         [](const auto& param_info) { return param_info.param.name; });

// The support's work on the layer is the toughness times the area; on the way back there is none.
TEST_P(PulledOff, TakesTheToughnessTimesTheArea) {
  const PullCase& c = GetParam();
  AttachedBlock block{.motion_W = c.way, .scale = c.scale};
  OrganBench bench;
  block.AddTo(&bench);
  bench.Start();
  double work = 0, largest = 0;
  Vector3d offset_W = Vector3d::Zero(), load_W = offset_W;
  std::vector<double> damage = DamageOf(bench);
  for (int step = 0; step <= 2 * c.steps; ++step) {
    bench.StayAt(step * kHalfMotion / c.steps);
    bench.Step();
    const Vector3d now_W = bench.organ(1).offset_W, pull_W = OutcomeOf(bench).load_W;
    work += 0.5 * (load_W + pull_W).dot(now_W - offset_W);
    offset_W = now_W;
    load_W = pull_W;
    largest = std::max(largest, pull_W.norm());
    const std::vector<double> grown = DamageOf(bench);
    for (std::size_t i = 0; i < damage.size(); ++i) EXPECT_GE(grown[i], damage[i]) << step;
    damage = grown;
    if (step == c.steps) {
      EXPECT_EQ(load_W, Vector3d::Zero()) << "nothing holds it";
    }
  }
  const double area = block.Area(), free = block.Layer().toughness * area;
  EXPECT_NEAR(OutcomeOf(bench).freed_area, area, 0.01 * area);
  EXPECT_NEAR(OutcomeOf(bench).dissipated, free, 0.01 * free);
  EXPECT_NEAR(work, free, 0.02 * free);
  EXPECT_NEAR(largest, block.Layer().strength * area, 0.05 * block.Layer().strength * area);
}

// A plate without a support is peeled off by its end: the hand's work is the toughness times the
// area and what the tissue stores.
TEST(AttachedOrgans, APeelByTheJawsTakesTheToughnessTimesTheArea) {
  AttachedBlock block{.young = 6e5,
                      .height = 0.004,
                      .size = Vector3d(0.06, 0.02, 0),
                      .cells = {8, 2, 2},
                      .held = false};
  OrganBench bench;
  block.AddTo(&bench);
  StartWithGrasper(&bench);
  const Vector3d start(-0.025, 0, block.height + 0.0023);
  double work = 0, last = 0, height = 0;
  for (int step = 0; step <= 600 && OutcomeOf(bench).freed_area < 0.999 * block.Area(); ++step) {
    const double lift = 0.15 * std::max(0, step - 2) / 600;
    ToolPose tool = OrganBench::Above(start + Vector3d(0, 0, lift));
    tool.jaw = step < 2 ? 1 : 0.05;
    bench.Step(tool);
    const double force = bench.ToolForce(1).z();
    if (step >= 2) work += 0.5 * (force + last) * (lift - height);
    last = force;
    height = lift;
  }
  const double area = block.Area(), free = block.Layer().toughness * area;
  EXPECT_NEAR(OutcomeOf(bench).freed_area, area, 0.01 * area);
  const Points& U = bench.organ(1).control_displacements;
  const Eigen::Map<const Eigen::VectorXd> u(U.data(), U.size());
  const double stored = 0.5 * u.dot(std::get<FullStiffness>(bench.model(1).stiffness()) * u);
  EXPECT_LT(stored, 0.3 * free);
  EXPECT_NEAR(work, free + stored, 0.05 * free);
}

// Tears the block in part, then moves its jaws a little back: no damage grows, so the response is
// linear and the patch's compliance is that of two solved steps.
TEST(AttachedOrgans, TheHandFeelsTheDamagedLayer) {
  Matrix3d undamaged_W;
  for (const double pull : {0.0002, 0.006}) {
    AttachedBlock block{.young = 3e5, .size = Vector3d(0.04, 0.02, 0), .held = false};
    OrganBench bench;
    block.AddTo(&bench);
    StartWithGrasper(&bench);
    ToolPose tool = OrganBench::Above(Vector3d(-0.01, 0, block.height + 0.0023));
    bench.Step(tool);
    tool.jaw = 0.05;
    for (int step = 0; step < 60; ++step) {
      tool.X_WT.translation().z() += pull / 60;
      bench.Step(tool);
    }
    for (int step = 0; step < 10; ++step) {
      tool.X_WT.translation().z() -= 0.001 * pull;
      bench.Step(tool);
    }
    EXPECT_EQ(OutcomeOf(bench).largest_damage > 0.1, pull > 0.001);
    const ToolPatch& patch = bench.patch.Front().tools[0].main();
    const Matrix3d compliance_W = patch.compliance_W;
    const Vector3d force_W = bench.ToolForce(1), back_W = 1e-3 * pull * Vector3d(0.3, 0.2, -1);
    tool.X_WT.translation() += back_W;
    bench.Step(tool);
    const Vector3d change_W = bench.ToolForce(1) - force_W;
    EXPECT_LT((compliance_W * change_W - back_W).norm(), 0.02 * back_W.norm()) << pull;
    if (pull < 0.001) undamaged_W = compliance_W;
    if (pull > 0.001) {
      EXPECT_GT(compliance_W(2, 2), 1.2 * undamaged_W(2, 2));
    }
  }
}

TEST(AttachedOrgans, ABlockWithoutASupportFollowsTheOrganThatHoldsIt) {
  AttachedBlock block{.held = false, .plate_motion_W = Vector3d(0.004, -0.002, 0.003)};
  OrganBench bench;
  block.AddTo(&bench);
  bench.Start();
  bench.Step();
  EXPECT_FALSE(bench.organ(1).awake);
  for (const double moment : {0.5, 1.0, 2.0}) {
    bench.StayAt(moment);
    bench.Step();
    const Vector3d way_W = bench.organ(0).offset_W;
    const Points moved = bench.organ(1).vertices - bench.model(1).rest().vertices;
    for (Eigen::Index v = 0; v < moved.rows(); ++v) {
      EXPECT_LT((moved.row(v).transpose() - way_W).norm(), 0.01 * 0.006) << moment;
    }
    EXPECT_EQ(OutcomeOf(bench).largest_damage, 0);
  }
}

// The pressure of a torn layer that closes again, up to the slide at which it is torn.
TEST(AttachedOrgans, ATornLayerStillCarriesPressure) {
  AttachedBlock block{.motion_W = Vector3d(0, 0, 0.012)};
  OrganBench bench;
  block.AddTo(&bench);
  ToolOptions probe;
  bench.Start({probe});
  const auto press = [&] {
    for (int step = 0; step < 3; ++step) {
      bench.StayAt(0);
      bench.Step(OrganBench::Above(Vector3d(0, 0, 0.01 + kDefaultToolRadius - 0.001)));
    }
    return OutcomeOf(bench).load_W.z();  // of the layer on the plate
  };
  const double before = press();
  for (int step = 0; step <= 100; ++step) {
    bench.StayAt(2.0 * step / 100);
    bench.Step();
  }
  EXPECT_NEAR(OutcomeOf(bench).freed_area, block.Area(), 0.01 * block.Area());
  const double after = press();
  EXPECT_LT(before, -0.01);
  EXPECT_LT(after, before) << "it no longer pulls around the tip";
}

TEST(AttachedOrgans, SleepAtRestAndWakeTogether) {
  OrganBench bench;
  AttachedBlock block{.held = false};
  block.AddTo(&bench);
  bench.Start();
  bench.Step();
  EXPECT_FALSE(bench.organ(1).awake);
  bench.Step(OrganBench::Above(Vector3d(0, 0, block.height + kDefaultToolRadius - 0.0005)));
  EXPECT_TRUE(bench.organ(1).awake);
  bench.Step();
  EXPECT_TRUE(bench.organ(1).control_displacements.isZero(0));
  EXPECT_FALSE(bench.organ(1).awake);
}

TEST(AttachedOrgans, ACopyTearsToTheLastBit) {
  AttachedBlock block{.held = false, .functions = 8};
  OrganBench bench;
  block.AddTo(&bench);
  StartWithGrasper(&bench);
  ToolState tools;
  tools.tool_count = 1;
  TripleBuffer<ToolState> edge;
  TripleBuffer<ContactPatch> patch;
  TripleBuffer<SceneSnapshot> render, telemetry;
  std::optional<DeformationLoop> copy;
  for (int step = 0; step < 60; ++step) {
    if (step == 30) {
      copy.emplace(bench.loop());
      copy->Attach({edge, patch, render, telemetry});
    }
    const ToolPose tool = GraspAndLift(block.height, step);
    const double before = bench.seconds();
    bench.Step(tool);
    if (!copy) continue;
    tools.tick = static_cast<std::uint64_t>(step) + 1;
    tools.time_ns = static_cast<Nanoseconds>(std::llround(before * kNanosecondsPerSecond));
    tools.tools[0] = tool;
    copy->Step(tools, tools.time_ns);
    ASSERT_EQ(copy->organ(1).control_displacements, bench.organ(1).control_displacements) << step;
    const auto damage = copy->links()[0].state().damage();
    ASSERT_TRUE(std::ranges::equal(damage, bench.loop().links()[0].state().damage())) << step;
  }
  EXPECT_GT(OutcomeOf(bench).largest_damage, 0.3);
}

TEST(AttachedOrgans, AStepThatTearsAllocatesNothing) {
  if (!kCountsAllocations) GTEST_SKIP() << "the sanitizer's allocator";
  AttachedBlock block{
      .size = Vector3d(0.05, 0.04, 0), .cells = {5, 4, 2}, .held = false, .functions = 8};
  OrganBench bench;
  block.AddTo(&bench);
  StartWithGrasper(&bench);
  bench.Step(GraspAndLift(block.height, 0));
  const long before = AllocationsOfThisThread();
  for (int step = 0; step < 60; ++step) bench.Step(GraspAndLift(block.height, step));
  EXPECT_EQ(AllocationsOfThisThread(), before);
  EXPECT_GT(OutcomeOf(bench).largest_damage, 0.3);
}

}  // namespace
}  // namespace hpdm
