// Leaves: sheets between two lines on the organs' surfaces.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <string>
#include <vector>

#include "engine/attachment/attachment_bed.h"
#include "engine/base/error.h"
#include "tests/support/shapes.h"
#include "tools/shared/organ_bench.h"

namespace hpdm {
namespace {

constexpr double kLeafMotion = 1;  // s: then an organ's offset is its whole displacement

// A rigid plate below z = 0, a stiff block above it whose top moves, and a leaf that stands on the plate
// along y = 0 and spans the gap between them.
struct LeafUnderBlock {
  double gap = 0.010;                    // m
  double lean = 0;                       // m, of the leaf's upper line along y
  Vector3d motion_W = Vector3d::Zero();  // m, of the block

  AttachmentOptions Leaf() const {
    AttachmentOptions leaf;
    leaf.a = "plate";
    leaf.b = "block";
    leaf.young = 1e5;
    leaf.thickness = 0.0003;
    leaf.strength = 5e4;
    leaf.toughness = 500;
    leaf.reach = 0.001;
    leaf.burn_energy = 5.7e5;
    leaf.paths_W = {std::vector<Vector3d>{{-0.012, 0, 0}, {0, 0, 0}, {0.012, 0, 0}},
                    std::vector<Vector3d>{{-0.012, lean, gap}, {0.012, lean, gap}}};
    return leaf;
  }
  OrganOptions PlateOptions() const {
    OrganOptions plate;
    plate.name = "plate";
    plate.model = OrganModelType::kRigid;
    return plate;
  }
  SurfaceMesh Plate() const {
    return GridBox(Vector3d(-0.06, -0.06, -0.01), Vector3d(0.06, 0.06, 0), {24, 24, 2});
  }
  OrganOptions BlockOptions() const {
    OrganOptions block;
    block.name = "block";
    block.material = {.young = 2e7, .poisson = 0.3};
    block.lattice.cells = {3, 3, 2};
    block.lattice.local.functions = 0;
    block.motion = {motion_W, 0.5 / kLeafMotion};
    block.supports.push_back({hpdm::Box{Vector3d(-1, -1, gap + 0.008), Vector3d(1, 1, 1)}, {}});
    return block;
  }
  SurfaceMesh Block() const {
    return GridBox(Vector3d(-0.015, -0.015, gap), Vector3d(0.015, 0.015, gap + 0.01), {12, 12, 4});
  }
  void AddTo(OrganBench* bench) const {
    bench->Add(PlateOptions(), Plate());
    bench->Add(BlockOptions(), Block());
    bench->Attach(Leaf());
  }
  AttachmentBed Bed(const AttachmentOptions& leaf) const {
    return {leaf, OrganModel(PlateOptions(), Plate()), OrganModel(BlockOptions(), Block())};
  }
  double Length() const { return std::hypot(gap, lean); }
  // N/m, of the whole leaf along its span.
  double Stiffness() const { return Leaf().young * Leaf().thickness * 0.024 / Length(); }
};

const AttachmentOutcome& LeafOutcome(const OrganBench& bench) {
  return bench.loop().links()[0].outcomes()[0];
}

TEST(LeafBed, ConsistsOfStripsOfItsOwnArea) {
  const LeafUnderBlock bodies{.lean = 0.006};
  const AttachmentBed bed = bodies.Bed(bodies.Leaf());
  ASSERT_EQ(bed.size(), 12);
  EXPECT_NEAR(bed.width, 0.002, 1e-12);
  EXPECT_NEAR(bed.areas.sum(), 0.024 * bodies.Length(), 1e-9);
  for (int i = 0; i < bed.size(); ++i) {
    const Vector3d normal_W = bed.normals_W.row(i), edge_W = bed.edges_W.row(i);
    EXPECT_LT((normal_W - Vector3d(0, 0.006, 0.010).normalized()).norm(), 1e-9);
    EXPECT_LT((edge_W - Vector3d::UnitX()).norm(), 1e-9);
    EXPECT_NEAR(bed.points_W[0](i, 0), -0.011 + 0.002 * i, 1e-9);
  }
}

TEST(LeafBed, RefusesWhatItCannotSpan) {
  const LeafUnderBlock bodies;
  const auto fault = [&](const std::function<void(AttachmentOptions*)>& change) -> std::string {
    AttachmentOptions leaf = bodies.Leaf();
    change(&leaf);
    try {
      bodies.Bed(leaf);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(fault([](AttachmentOptions*) {}), "");
  EXPECT_NE(
      fault([](AttachmentOptions* leaf) { leaf->paths_W[1][0].z() -= 0.003; }).find("path_b at"),
      std::string::npos);
  EXPECT_NE(fault([](AttachmentOptions* leaf) { leaf->toughness = 124; }).find("125 J/m^2"),
            std::string::npos);
  const LeafUnderBlock touching{.gap = 0.0002};
  AttachmentOptions leaf = touching.Leaf();
  EXPECT_THROW(touching.Bed(leaf), InputError);
}

// The whole course of the load, for a straight leaf and one that leans.
TEST(Leaf, PullsByItsModulusUpToItsStrengthAndTearsByItsToughness) {
  for (const double lean : {0.0, 0.006}) {
    LeafUnderBlock bodies{.lean = lean};
    const Vector3d span_W = Vector3d(0, lean, bodies.gap).normalized();
    bodies.motion_W = 0.024 * span_W;
    const AttachmentOptions options = bodies.Leaf();
    OrganBench bench;
    bodies.AddTo(&bench);
    bench.Start();
    const double onset = options.strength * bodies.Length() / options.young,
                 last = 2 * options.toughness / options.strength,
                 most = options.strength * options.thickness * 0.024;
    constexpr int kSteps = 240;
    for (int step = 0; step <= kSteps; ++step) {
      bench.StayAt(step * kLeafMotion / kSteps);
      bench.Step();
      const double delta = bench.organ(1).offset_W.dot(span_W);
      const double expected = delta < onset  ? bodies.Stiffness() * delta
                              : delta < last ? most * (last - delta) / (last - onset)
                                             : 0;
      EXPECT_NEAR(-LeafOutcome(bench).load_W.dot(span_W), expected, 0.02 * most) << delta;
    }
    const double work = options.toughness * options.thickness * 0.024;
    EXPECT_NEAR(LeafOutcome(bench).dissipated, work, 0.001 * work);
    EXPECT_NEAR(LeafOutcome(bench).freed_area, 0.024 * bodies.Length(), 1e-9);
  }
}

TEST(Leaf, PullsAlongItsSpanOnly) {
  const auto load = [](const Vector3d& motion_W) -> Vector3d {
    const LeafUnderBlock bodies{.motion_W = motion_W};
    OrganBench bench;
    bodies.AddTo(&bench);
    bench.Start();
    for (int step = 0; step <= 60; ++step) {
      bench.StayAt(step * kLeafMotion / 60);
      bench.Step();
    }
    return LeafOutcome(bench).load_W;
  };
  const double k = LeafUnderBlock().Stiffness();
  EXPECT_LT(load({0, 0, -0.004}).norm(), 1e-4 * k * 0.004) << "the organs approach each other";
  EXPECT_LT(load({0, 0.004, 0}).norm(), 1e-4 * k * 0.004) << "across its face";
  EXPECT_LT(load({0.004, 0, 0}).norm(), 1e-4 * k * 0.004) << "along the lines";
  EXPECT_NEAR(load({0.003, 0.003, 0.004}).norm(), k * 0.004, 0.02 * k * 0.004);
}

// A hook that stands at the middle of the leaf burns the strips there and no others. Pulled on, these
// bear the load by themselves.
TEST(Leaf, OpensStripByStrip) {
  LeafUnderBlock bodies{.motion_W = Vector3d(0, 0, 0.004)};
  OrganBench bench;
  bodies.AddTo(&bench);
  ToolOptions hook;
  hook.geometries[0] = {.tip_radius = 1e-4, .shaft_radius = 1e-4, .action = ToolAction::kBurn};
  hook.geometries[0].power = 40;
  bench.Start({hook});
  ToolPose tool;
  tool.X_WT.translation() = Vector3d(0.001, 0, 0.005);
  tool.p_trocar_W = tool.X_WT.translation() + Vector3d(0, 0.2, 0);
  tool.pedal = true;
  for (int step = 0; step < 60; ++step) bench.Step(tool);  // the block moves up and down
  const auto damage = bench.loop().links()[0].state().damage();
  for (int i = 0; i < 12; ++i) {
    const double away = std::abs(-0.011 + 0.002 * i - 0.001);
    EXPECT_EQ(damage[ToSize(i)], away < 0.0025 ? 1 : 0) << i;
  }
  EXPECT_NEAR(LeafOutcome(bench).burnt_area, 3 * 0.002 * bodies.gap, 1e-9);
  tool.pedal = false;
  for (int step = 0; step < 30; ++step) bench.Step(tool);
  const double expected = 9.0 / 12 * bodies.Stiffness() * bench.organ(1).offset_W.z();
  EXPECT_GT(expected, 0.1);
  EXPECT_NEAR(-LeafOutcome(bench).load_W.z(), expected, 0.02 * expected);
}

}  // namespace
}  // namespace hpdm
