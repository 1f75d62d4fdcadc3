// Tests the weight that layers bear, and that damage gives it back.

#include "engine/attachment/borne_weight.h"

#include <gtest/gtest.h>

#include <string>

#include "engine/base/error.h"
#include "tests/support/bed_layer.h"
#include "tests/support/shapes.h"
#include "tools/shared/organ_bench.h"

namespace hpdm {
namespace {

// A stiff block under a rigid plate: a layer holds its upper face, and a spring its lower part.
struct HungBlock {
  double spring = 9000;  // N/m; 0: none
  double strength = 10000;
  double gravity = 9.81;  // m/s^2, downwards
  double plate_lift = 0;  // m
  static constexpr double kSide = 0.03, kHeight = 0.01;

  double Weight() const { return 1060 * kSide * kSide * kHeight * gravity; }
  double LayerStiffness() const { return kSide * kSide * 20000 / 0.001; }
  // The share of a spring that is parallel to another.
  double Borne() const { return Weight() * LayerStiffness() / (LayerStiffness() + spring); }

  AttachmentOptions Layer() const {
    AttachmentOptions layer =
        BedLayer("block", "plate", hpdm::Box{Vector3d(-1, -1, -1), Vector3d(1, 1, 1)}, 0.001);
    layer.strength = strength;
    return layer;
  }

  void AddTo(OrganBench* bench) const {
    OrganOptions plate;
    plate.name = "plate";
    plate.model = OrganModelType::kRigid;
    plate.gravity_W = Vector3d(0, 0, -gravity);
    plate.motion = {Vector3d(0, 0, plate_lift), 0.5};
    bench->Add(plate, GridBox(Vector3d(-0.06, -0.06, 0), Vector3d(0.06, 0.06, 0.01), {24, 24, 2}));
    OrganOptions block;
    block.name = "block";
    block.material = {.young = 1e8, .poisson = 0.3};
    block.lattice.cells = {3, 3, 2};
    block.lattice.margin = 0.0005;
    block.lattice.local.functions = 0;
    block.gravity_W = plate.gravity_W;
    if (spring > 0) {
      const double volume = kSide * kSide * 0.004;  // below
      block.supports.push_back(
          {hpdm::Box{Vector3d(-1, -1, -1), Vector3d(1, 1, 0.0037 - kHeight)}, spring / volume});
    }
    const double half = kSide / 2;
    bench->Add(block, GridBox(Vector3d(-half, -half, -kHeight - 0.0003),
                              Vector3d(half, half, -0.0003), {12, 12, 4}));
    bench->Attach(Layer());
  }
};

const AttachmentOutcome& LayerAfterStep(const OrganBench& bench) {
  return bench.loop().links()[0].outcomes()[0];
}

TEST(BorneWeight, NothingMovesAtTheStartAndTheLayerBearsItsShare) {
  const HungBlock block;
  OrganBench bench;
  block.AddTo(&bench);
  bench.Start();
  bench.Step(OrganBench::Above(Vector3d(0.01, 0, 0.011)));  // at the plate
  for (int step = 0; step < 3; ++step) bench.Step();
  EXPECT_TRUE(bench.organ(1).control_displacements.isZero(0));
  const AttachmentBed& bed = bench.loop().links()[0].joint().layers()[0].bed;
  const Vector3d borne_W = BorneWeight({bench.model(0), bench.model(1)}, {bed})[0];
  // The layer pulls b, the plate, downwards.
  EXPECT_NEAR(borne_W.z(), -block.Borne(), 0.01 * block.Borne());
  EXPECT_LT(borne_W.head<2>().norm(), 1e-3 * block.Borne());
}

TEST(BorneWeight, ATornLayerGivesItsLoadBack) {
  const HungBlock block{.plate_lift = 0.012};
  OrganBench bench;
  block.AddTo(&bench);
  bench.Start();
  for (int step = 0; step <= 120; ++step) {
    bench.StayAt(step / 60.0);  // up, and down again
    bench.Step();
    if (step == 0) {
      EXPECT_NEAR(LayerAfterStep(bench).load_W.z(), -block.Borne(), 0.01 * block.Borne());
    }
  }
  EXPECT_NEAR(LayerAfterStep(bench).freed_area, 9e-4, 0.01 * 9e-4);
  const Points moved = bench.organ(1).vertices - bench.model(1).rest().vertices;
  const double sunk = block.Borne() / block.spring;
  EXPECT_NEAR(moved.col(2).mean(), -sunk, 0.01 * sunk);
}

TEST(BorneWeight, AnOverloadedLayerIsRefusedWithItsPlace) {
  const HungBlock block{.strength = 50};
  OrganBench bench;
  block.AddTo(&bench);
  try {
    bench.Start();
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("beyond its strength of 50 Pa"), std::string::npos)
        << error.what();
    EXPECT_NE(std::string(error.what()).find(" at ["), std::string::npos) << error.what();
  }
}

TEST(BorneWeight, AnOrganWithoutASupportOrWithoutGravityLeavesTheLayerUnloaded) {
  for (const HungBlock& block : {HungBlock{.spring = 0}, HungBlock{.gravity = 0}}) {
    OrganBench bench;
    block.AddTo(&bench);
    bench.Start();
    const AttachmentBed& bed = bench.loop().links()[0].joint().layers()[0].bed;
    EXPECT_EQ(BorneWeight({bench.model(0), bench.model(1)}, {bed})[0], Vector3d::Zero());
  }
}

}  // namespace
}  // namespace hpdm
