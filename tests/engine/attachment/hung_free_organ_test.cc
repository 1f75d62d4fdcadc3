// A free organ that a layer holds, and what it does once the layer is torn.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "engine/base/error.h"
#include "tests/support/bed_layer.h"
#include "tests/support/counted_allocations.h"
#include "tests/support/shapes.h"
#include "tools/shared/organ_bench.h"

namespace hpdm {
namespace {

constexpr double kG = 9.81;        // m/s^2
constexpr double kDensity = 1060;  // kg/m^3
constexpr double kShake = 3;       // Hz

// A block under a rigid plate whose lower face is at z = 0.
struct FreeBlock {
  double young = 2e5;                           // Pa
  Vector3d sides = Vector3d(0.04, 0.03, 0.03);  // m
  std::array<int, 3> cells = {3, 3, 3};
  double gravity = kG;
  double drag = 1;         // 1/s
  double strength = 1500;  // Pa
  double toughness = 2;    // J/m^2
  bool free = true;
  std::optional<double> friction = std::nullopt;  // of a contact of the two
  Vector3d plate_motion_W = Vector3d::Zero();

  double Weight() const { return kDensity * sides.prod() * gravity; }
  AttachmentOptions Layer() const {
    AttachmentOptions layer =
        BedLayer("block", "plate", hpdm::Box{Vector3d(-1, -1, -1), Vector3d(1, 1, 1)}, 0.001);
    layer.strength = strength;
    layer.toughness = toughness;
    return layer;
  }
  void AddTo(OrganBench* bench) const {
    OrganOptions plate;
    plate.name = "plate";
    plate.model = OrganModelType::kRigid;
    plate.gravity_W = Vector3d(0, 0, -gravity);
    plate.motion = {plate_motion_W, kShake};
    bench->Add(plate, GridBox(Vector3d(-0.06, -0.06, 0), Vector3d(0.06, 0.06, 0.01), {24, 24, 2}));
    OrganOptions block;
    block.name = "block";
    block.material = {.young = young, .poisson = 0.3};
    block.material.density = kDensity;
    block.lattice.cells = cells;
    block.lattice.margin = 0.0005;
    block.lattice.local.functions = 0;
    block.gravity_W = plate.gravity_W;
    if (free) block.free = FreeOptions{drag};
    const Vector3d low(-sides.x() / 2, -sides.y() / 2, -0.0003 - sides.z());
    bench->Add(block, GridBox(low, low + sides, {8, 6, 6}), friction);
    bench->Attach(Layer());
  }
};

const AttachmentOutcome& LayerOf(const OrganBench& bench) {
  return bench.loop().links()[0].outcomes()[0];
}

double Height(const OrganBench& bench) { return bench.organ(1).vertices.col(2).mean(); }

void StartWithJaws(OrganBench* bench) {
  ToolOptions grasper;
  grasper.geometries[0].can_grasp = true;
  bench->Start({grasper});
}

// Jaws at the block's lower face, whose shaft comes from below.
ToolPose FromBelow(const FreeBlock& block, double jaw, double down) {
  ToolPose tool;
  tool.X_WT.translation() = Vector3d(0, 0, -0.0026 - block.sides.z() - down);
  tool.X_WT.linear() = Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitX()).toRotationMatrix();
  tool.p_trocar_W = tool.X_WT.translation() - Vector3d(0, 0, 0.3);
  tool.jaw = jaw;
  return tool;
}

// Tears the block off by jaws that go down by 25 mm, and holds it still there.
void TearOff(const FreeBlock& block, OrganBench* bench) {
  for (int k = 0; k < 3; ++k) bench->Step(FromBelow(block, 1, -0.0005));
  for (int k = 0; k < 3; ++k) bench->Step(FromBelow(block, 0.05, 0));
  for (int k = 0; k < 50; ++k) bench->Step(FromBelow(block, 0.05, 0.0005 * k));
  for (int k = 0; k < 30; ++k) bench->Step(FromBelow(block, 0.05, 0.025));
}

TEST(HungFreeOrgan, HangsStillAndTheLayerBearsItsWholeWeight) {
  for (const double gravity : {0.0, 1.6, kG}) {
    const FreeBlock block{.gravity = gravity};
    OrganBench bench;
    block.AddTo(&bench);
    bench.Start();
    const Points rest = bench.organ(1).vertices;
    for (int k = 0; k < 90; ++k) bench.Step();
    EXPECT_LT((bench.organ(1).vertices - rest).cwiseAbs().maxCoeff(), 1e-8) << gravity;
    EXPECT_NEAR(LayerOf(bench).load_W.z(), -block.Weight(), 1e-3 * block.Weight() + 1e-9);
    EXPECT_LT(LayerOf(bench).load_W.head<2>().norm(), 1e-3 * block.Weight() + 1e-9);
    EXPECT_EQ(LayerOf(bench).largest_damage, 0);
  }
}

TEST(HungFreeOrgan, RefusesALayerThatTheWeightOverloads) {
  const FreeBlock block{.strength = 300};  // 312 Pa in the mean
  OrganBench bench;
  block.AddTo(&bench);
  EXPECT_THROW(bench.Start(), InputError);
}

// The same block without [organ.free], which a weak spring of about a thousandth of its stiffness holds.
TEST(HungFreeOrgan, AHeldPullIsThatOfAnOrganWithoutMass) {
  double pulled[2], force[2];  // along the pull
  for (const bool free : {true, false}) {
    const FreeBlock block{.gravity = 0, .strength = 10000, .toughness = 45, .free = free};
    OrganBench bench;
    block.AddTo(&bench);
    StartWithJaws(&bench);
    const double from = Height(bench);
    for (int k = 0; k < 3; ++k) bench.Step(FromBelow(block, 1, -0.0005));
    for (int k = 0; k < 3; ++k) bench.Step(FromBelow(block, 0.05, 0));
    for (int k = 0; k < 90; ++k) bench.Step(FromBelow(block, 0.05, std::min(20e-6 * k, 1e-3)));
    EXPECT_EQ(LayerOf(bench).largest_damage, 0);
    pulled[free ? 0 : 1] = from - Height(bench);
    force[free ? 0 : 1] = -bench.ToolForce(1).z();
  }
  EXPECT_GT(force[1], 1);
  EXPECT_NEAR(pulled[0], pulled[1], 0.005 * pulled[1]);
  EXPECT_NEAR(force[0], force[1], 0.005 * force[1]);
}

TEST(HungFreeOrgan, HasItsWeightOnceItIsTornOff) {
  const FreeBlock block;
  OrganBench bench;
  block.AddTo(&bench);
  StartWithJaws(&bench);
  TearOff(block, &bench);
  ASSERT_NEAR(LayerOf(bench).freed_area, block.sides.x() * block.sides.y(), 1e-5);
  EXPECT_NEAR(bench.ToolForce(1).z(), block.Weight(), 0.01 * block.Weight());
  EXPECT_LT(bench.ToolForce(1).head<2>().norm(), 0.01 * block.Weight());
}

// Returns how far a body falls in t (s) that has the speed v at first (m/s, downwards).
double Fall(double drag, double v, double t) {
  if (drag == 0) return v * t + kG * t * t / 2;
  return kG / drag * t + (v - kG / drag) * -std::expm1(-drag * t) / drag;
}

// A layer that just bears the weight, under a plate that shakes by 30 mm.
TEST(HungFreeOrgan, FallsAsABodyWithDragFromAPlateThatShakesItOff) {
  for (const double drag : {0.0, 1.0, 5.0}) {
    const FreeBlock block{
        .drag = drag, .strength = 420, .toughness = 0.2, .plate_motion_W = Vector3d(0, 0, 0.03)};
    OrganBench bench;
    block.AddTo(&bench);
    bench.Start();
    std::vector<double> heights = {Height(bench)};  // from the step in which it leaves
    bool torn = false;
    for (int k = 1; k <= 60; ++k) {
      bench.Step();
      const bool leaves =
          !torn && LayerOf(bench).freed_area > 0.99 * block.sides.x() * block.sides.y();
      if (leaves) {
        // The shake moves it by up to 0.3 m/s.
        EXPECT_LT(std::abs(Height(bench) - heights.back()) * 30, 0.8) << "no jump";
        torn = true;
      }
      if (leaves || !torn) heights.clear();
      heights.push_back(Height(bench));
    }
    ASSERT_TRUE(torn);
    ASSERT_GT(heights.size(), 30u);
    // The speed in which it leaves is that of its first step.
    const double dt = 1 / 30.0, first = heights[0] - heights[1];
    const double unit = Fall(drag, 1, dt) - Fall(drag, 0, dt);
    const double speed = (first - Fall(drag, 0, dt)) / unit;
    for (std::size_t k = 2; k < heights.size(); ++k) {
      const double fallen = Fall(drag, speed, static_cast<double>(k) * dt);
      EXPECT_NEAR(heights[0] - heights[k], fallen, 0.01 * fallen) << drag << ' ' << k;
    }
  }
}

TEST(HungFreeOrgan, TouchesWhatItHungOnOnceItIsTornOff) {
  FreeBlock block{.gravity = 0, .friction = 0.1};
  OrganBench bench;
  block.AddTo(&bench);
  StartWithJaws(&bench);
  TearOff(block, &bench);
  ASSERT_NEAR(LayerOf(bench).freed_area, block.sides.x() * block.sides.y(), 1e-5);
  EXPECT_EQ(bench.PairForce(1), Vector3d::Zero());
  // Back up and 3 mm into the plate.
  for (int k = 0; k < 60; ++k) bench.Step(FromBelow(block, 0.05, 0.025 - 0.0005 * k));
  EXPECT_LT(bench.PairForce(1).z(), -0.05);
  EXPECT_LT(bench.organ(1).vertices.col(2).maxCoeff(), 0.0005);
}

TEST(HungFreeOrgan, ACopyTearsAndFallsToTheLastBit) {
  const FreeBlock block;
  OrganBench bench;
  block.AddTo(&bench);
  StartWithJaws(&bench);
  ToolState tools;
  tools.tool_count = 1;
  TripleBuffer<ToolState> edge;
  TripleBuffer<ContactPatch> patch;
  TripleBuffer<SceneSnapshot> render, telemetry;
  std::optional<DeformationLoop> copy;
  for (int step = 0; step < 90; ++step) {
    if (step == 20) {
      copy.emplace(bench.loop());
      copy->Attach({edge, patch, render, telemetry});
    }
    const ToolPose tool = FromBelow(block, step < 3 ? 1 : 0.05, 0.0005 * step - 0.001);
    const double before = bench.seconds();
    bench.Step(tool);
    if (!copy) continue;
    tools.tick = static_cast<std::uint64_t>(step) + 1;
    tools.time_ns = static_cast<Nanoseconds>(std::llround(before * kNanosecondsPerSecond));
    tools.tools[0] = tool;
    copy->Step(tools, tools.time_ns);
    ASSERT_EQ(copy->organ(1).control_displacements, bench.organ(1).control_displacements) << step;
  }
  EXPECT_NEAR(LayerOf(bench).freed_area, block.sides.x() * block.sides.y(), 1e-5);
}

TEST(HungFreeOrgan, AStepThatLetsGoAllocatesNothing) {
  if (!kCountsAllocations) GTEST_SKIP() << "the sanitizer's allocator";
  const FreeBlock block{.friction = 0.1};
  OrganBench bench;
  block.AddTo(&bench);
  StartWithJaws(&bench);
  for (int k = 0; k < 3; ++k) bench.Step(FromBelow(block, 1, -0.0005));
  for (int k = 0; k < 3; ++k) bench.Step(FromBelow(block, 0.05, 0));
  const long before = AllocationsOfThisThread();
  for (int k = 0; k < 80; ++k) bench.Step(FromBelow(block, 0.05, 0.0005 * k));
  EXPECT_EQ(AllocationsOfThisThread(), before);
  EXPECT_NEAR(LayerOf(bench).freed_area, block.sides.x() * block.sides.y(), 1e-5);
}

}  // namespace
}  // namespace hpdm
