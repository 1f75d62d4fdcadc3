// A step that a finite-strain organ rejects is solved once more: the organs that are solved with it move
// by one step only.

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "tests/support/bed_layer.h"
#include "tests/support/counted_allocations.h"
#include "tests/support/shapes.h"
#include "tools/shared/organ_bench.h"

namespace hpdm {
namespace {

// A free block close above a pad in finite strain, and a rigid plate close above the block. A layer may
// join the two.
struct PadBelow {
  bool layer = false;
  double lift = 0;          // m/s^2, upwards: a gravity
  double shake = 0;         // m: the plate's way along x
  double strength = 10000;  // Pa
  double tolerance = 1e-9;  // m: where damage grows, a step's rounds depend on the pad's
  bool violent = false;     // jaws pull the pad too far, else they stay away
  static constexpr double kLow = 0.0506, kHigh = kLow + 0.02;  // m: the block's faces

  void Start(OrganBench* bench) const {
    OrganOptions pad;
    pad.name = "pad";
    pad.energy.strain = StrainMeasure::kFinite;
    pad.energy.law = MaterialLaw::kStVenantKirchhoff;
    pad.lattice.cells = {2, 2, 2};
    pad.lattice.local.functions = 0;
    pad.gravity_W = Vector3d(0, 0, lift);
    pad.supports = {{BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.25)}, {}}};
    bench->Add(pad, Ellipsoid(Vector3d(0.1, 0.07, 0.05), 3));
    OrganOptions block;
    block.name = "block";
    block.material = {.young = 1e5, .poisson = 0.3};
    block.lattice.cells = {3, 3, 3};
    block.lattice.margin = 0.0005;
    block.lattice.local.functions = 0;
    block.gravity_W = pad.gravity_W;
    block.free = FreeOptions{1};
    bench->Add(block, GridBox(Vector3d(-0.03, -0.01, kLow), Vector3d(0, 0.01, kHigh), {8, 6, 6}),
               0.0);
    OrganOptions plate;
    plate.name = "plate";
    plate.model = OrganModelType::kRigid;
    plate.gravity_W = pad.gravity_W;
    plate.motion = {Vector3d(shake, 0, 0), 3};
    bench->Add(plate, GridBox(Vector3d(-0.06, -0.03, kHigh + 0.0003),
                              Vector3d(0.03, 0.03, kHigh + 0.01), {24, 16, 2}));
    if (layer) {
      AttachmentOptions joined =
          BedLayer("block", "plate", hpdm::Box{Vector3d(-1, -1, -1), Vector3d(1, 1, 1)}, 0.001);
      joined.strength = strength;
      joined.toughness = 45 * strength * strength / 1e8;
      bench->Attach(joined);
    }
    ToolOptions grasper;
    grasper.geometries[0].can_grasp = true;
    bench->Start({grasper});
  }
  // Jaws beside the block; they close in the second step and are far down from the third one.
  ToolPose ToolAt(int step) const {
    if (!violent) return OrganBench::Away();
    ToolPose tool = OrganBench::Above(Vector3d(0.05, 0, 0.0455 - (step < 3 ? 0 : 0.14)));
    tool.jaw = step < 1 ? 1 : 0.05;
    return tool;
  }
};

struct Way {
  std::vector<Points> shapes;  // of the block
  int rejected = 0;            // steps
  long allocations = 0;
};

Way WayOf(const PadBelow& pad, int steps) {
  OrganBench bench;
  pad.Start(&bench);
  Way way;
  for (int step = 0; step < steps; ++step) {
    const long before = AllocationsOfThisThread();
    bench.Step(pad.ToolAt(step));
    way.allocations += AllocationsOfThisThread() - before;
    way.shapes.push_back(bench.organ(1).vertices);
    way.rejected += (bench.record().flags & kStepRecovering) != 0 ? 1 : 0;
    EXPECT_EQ(bench.PairForce(1), Vector3d::Zero()) << "the block touches nothing";
  }
  return way;
}

class RepeatedStep : public testing::TestWithParam<PadBelow> {};
INSTANTIATE_TEST_SUITE_P(
    Cases, RepeatedStep,
    testing::Values(PadBelow{.lift = 0.3}, PadBelow{.layer = true, .shake = 0.004},
                    PadBelow{.layer = true, .shake = 0.02, .strength = 100, .tolerance = 2e-5}));

TEST_P(RepeatedStep, MovesTheOthersOnce) {
  PadBelow pad = GetParam();
  constexpr int kSteps = 10;
  const Way alone = WayOf(pad, kSteps);
  pad.violent = true;
  const Way beside = WayOf(pad, kSteps);
  EXPECT_EQ(alone.rejected, 0);
  EXPECT_GT(beside.rejected, 0);
  EXPECT_GT((alone.shapes.back() - alone.shapes.front()).cwiseAbs().maxCoeff(), 1e-4);
  for (std::size_t step = 0; step < ToSize(kSteps); ++step) {
    EXPECT_LT((beside.shapes[step] - alone.shapes[step]).cwiseAbs().maxCoeff(), pad.tolerance)
        << step;
  }
  if (kCountsAllocations) {
    EXPECT_EQ(beside.allocations, 0);
  }
}

}  // namespace
}  // namespace hpdm
