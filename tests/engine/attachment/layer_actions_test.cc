// Instruments that burn and cut the layers between organs, in the deformation loop.

#include "engine/step/layer_actions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "tests/support/bed_layer.h"
#include "tests/support/counted_allocations.h"
#include "tests/support/shapes.h"
#include "tools/shared/organ_bench.h"

namespace hpdm {
namespace {

constexpr double kDt = 1.0 / 30;  // s
constexpr double kThin = 1e-4;    // m: a tool that fits into the gap without touching

// A rigid plate below z = 0 and a block of 40 x 40 x 10 mm on it, joined by a layer.
struct Bed {
  double scale = 1;
  double burn_energy = 1.9e6;            // J/m^2
  bool held = true;                      // the block at its top
  Vector3d motion_W = Vector3d::Zero();  // m, of the block's support

  double Area() const { return scale * scale * 0.04 * 0.04; }
  AttachmentOptions Layer() const {
    AttachmentOptions layer = BedLayer(
        "block", "plate", hpdm::Box{Vector3d(-1, -1, -1), Vector3d(1, 1, 1)}, 0.001 * scale);
    layer.burn_energy = burn_energy;
    return layer;
  }
  void AddTo(OrganBench* bench) const {
    OrganOptions plate;
    plate.name = "plate";
    plate.model = OrganModelType::kRigid;
    bench->Add(plate, GridBox(Vector3d(-0.06, -0.06, -0.01) * scale,
                              Vector3d(0.06, 0.06, 0) * scale, {24, 24, 2}));
    OrganOptions block;
    block.name = "block";
    block.material = {.young = 2e5, .poisson = 0.3};
    block.lattice.cells = {4, 4, 2};
    block.lattice.margin = 0.0005 * scale;
    block.lattice.local.functions = 0;
    block.motion = {motion_W, 0.5};
    if (held) {
      block.supports.push_back({hpdm::Box{Vector3d(-1, -1, 0.008 * scale), Vector3d(1, 1, 1)}, {}});
    }
    bench->Add(block, GridBox(Vector3d(-0.02, -0.02, 0.0003) * scale,
                              Vector3d(0.02, 0.02, 0.01) * scale, {16, 16, 4}));
    bench->Attach(Layer());
  }
};

ToolOptions With(ToolAction action) {
  ToolOptions tool;
  tool.geometries[0] = {.tip_radius = kThin, .shaft_radius = kThin, .action = action};
  return tool;
}

// A tip in the gap between plate and block, its shaft along x, and its jaws in the plane of the layer.
ToolPose InGap(double x, double y) {
  ToolPose tool;
  tool.X_WT.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;  // x_T = -y, y_T = -z, z_T = x
  tool.X_WT.translation() = Vector3d(x, y, 0.00015);
  tool.p_trocar_W = tool.X_WT.translation() + Vector3d(0.2, 0, 0);
  return tool;
}

const AttachmentOutcome& ActedOutcome(const OrganBench& bench) {
  return bench.loop().links()[0].outcomes()[0];
}

// The area that the damage has taken.
double Damaged(const OrganBench& bench) {
  const auto damage = bench.loop().links()[0].state().damage();
  const Eigen::VectorXd& areas = bench.loop().links()[0].joint().layers()[0].bed.areas;
  return std::inner_product(damage.begin(), damage.end(), areas.data(), 0.0);
}

struct BurnCase {
  double scale, burn_energy, power;
};
class Burning : public testing::TestWithParam<BurnCase> {};
INSTANTIATE_TEST_SUITE_P(Cases, Burning,
                         testing::Values(BurnCase{1, 1.9e6, 40}, BurnCase{1, 1.9e6, 13},
                                         BurnCase{1, 0.6e6, 25}, BurnCase{2, 1.9e6, 80}));

// The area burnt is power x time / energy for an area, whatever the samples.
TEST_P(Burning, TakesTheAreaThatTheHeatVaporises) {
  const BurnCase& c = GetParam();
  const Bed bed{.scale = c.scale, .burn_energy = c.burn_energy};
  OrganBench bench;
  bed.AddTo(&bench);
  ToolOptions hook = With(ToolAction::kBurn);
  hook.geometries[0].power = c.power;
  bench.Start({hook});
  ToolPose tool = InGap(0.002, 0.001);
  for (int step = 0; step < 5; ++step) bench.Step(tool);
  EXPECT_EQ(Damaged(bench), 0) << "the pedal is not pressed";
  tool.pedal = true;
  for (int step = 1; step <= 9; ++step) {
    bench.Step(tool);
    const double area = c.power * step * kDt / c.burn_energy;
    EXPECT_NEAR(Damaged(bench), area, 1e-6 * area) << step;
  }
  const double burnt = Damaged(bench);
  tool.pedal = false;
  bench.Step(tool);
  EXPECT_EQ(Damaged(bench), burnt);
  EXPECT_LE(ActedOutcome(bench).burnt_area, burnt);
  EXPECT_EQ(ActedOutcome(bench).burnt_area, ActedOutcome(bench).freed_area) << "nothing tore";
}

// The second try burns in the same way, so that both are the same to the last bit.
TEST(LayerActions, ARestartMendsTheLayer) {
  const Bed bed;
  OrganBench bench;
  bed.AddTo(&bench);
  ToolOptions hook = With(ToolAction::kBurn);
  hook.geometries[0].power = 40;
  bench.Start({hook});
  bench.KeepSteps(2);
  const auto burn = [&](double x) {
    ToolPose tool = InGap(x, 0.001);
    tool.pedal = true;
    for (int step = 0; step < 9; ++step) bench.Step(tool);
    tool.pedal = false;
    bench.Step(tool);
    return Damaged(bench);
  };
  const double begin = burn(0.002);
  ASSERT_GT(begin, 0);
  bench.Reach(1);
  const double end = burn(-0.008);
  ASSERT_GT(end, 1.5 * begin);
  bench.Restart(1);
  bench.Step(InGap(-0.008, 0.001));
  EXPECT_EQ(Damaged(bench), begin);
  EXPECT_EQ(burn(-0.008), end);
}

TEST(LayerActions, AHookSaysWhichLayerItWouldBurnWithoutThePedal) {
  const Bed bed;
  OrganBench bench;
  bed.AddTo(&bench);
  ToolOptions hook = With(ToolAction::kBurn);
  hook.geometries[0].power = 1e6;  // burns all that it reaches in one step
  bench.Start({hook});
  const auto layer = [&](const ToolPose& tool) {
    bench.Step(tool);
    bench.render->Update();
    return bench.render->Front().readouts[0].layer;
  };
  ToolPose tool = InGap(0.002, 0.001);
  EXPECT_EQ(layer(OrganBench::Away()), -1);
  EXPECT_EQ(layer(tool), 0);
  EXPECT_EQ(Damaged(bench), 0) << "without the pedal";
  tool.pedal = true;
  layer(tool);
  tool.pedal = false;
  EXPECT_EQ(layer(tool), -1) << "all in reach is burnt";
}

// A sample is burnt if its disc comes within a millimetre of the tip; whole samples are.
TEST(LayerActions, HeatReachesAMillimetreAndNoFurther) {
  const Bed bed;
  OrganBench bench;
  bed.AddTo(&bench);
  ToolOptions hook = With(ToolAction::kBurn);
  hook.geometries[0].power = 1e6;  // burns all that it reaches in one step
  bench.Start({hook});
  const AttachmentBed& layer = bench.loop().links()[0].joint().layers()[0].bed;
  std::vector<double> nearest(ToSize(layer.size()), 1.0);  // m, of the tips from each sample
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      ToolPose tool = InGap(-0.0125 + 0.0083 * i, -0.0125 + 0.0079 * j);
      tool.pedal = true;
      bench.Step(tool);
      for (int s = 0; s < layer.size(); ++s) {
        const Vector3d middle = 0.5 * (layer.points_W[0].row(s) + layer.points_W[1].row(s));
        const double distance = (middle - tool.X_WT.translation()).norm();
        nearest[ToSize(s)] = std::min(nearest[ToSize(s)], distance);
      }
    }
  }
  int burnt = 0;
  for (int s = 0; s < layer.size(); ++s) {
    const double radius = std::sqrt(layer.areas[s] / std::numbers::pi);
    const double gap = nearest[ToSize(s)] - kThin - radius;  // m, between tip and disc
    const double damage = bench.loop().links()[0].state().damage()[ToSize(s)];
    // The fibres stand at a point of the surface near the sample's middle.
    if (gap < 0.0005) {
      EXPECT_EQ(damage, 1) << s;
    } else if (gap > 0.0015) {
      EXPECT_EQ(damage, 0) << s;
    }
    burnt += damage > 0 ? 1 : 0;
  }
  EXPECT_GT(burnt, 30);
  EXPECT_LT(burnt, layer.size() / 2);
}

TEST(LayerActions, SmokeRisesWhereAHookHeatsTissueAndNowhereElse) {
  OrganBench bench;
  Bed{}.AddTo(&bench);
  bench.Start({With(ToolAction::kBurn)});
  ToolPose tool = InGap(0.002, 0.001);
  const auto puffs = [&] {
    std::vector<Vector3d> places_W;
    bench.render->Update();
    const SceneSnapshot& scene = bench.render->Front();
    scene.smoke.ForEach(scene.step.time_ns, [&](const SmokePuff& puff, double age) {
      EXPECT_LT(age, SmokePuff::kLife);
      places_W.push_back(puff.p_W);
    });
    return places_W;
  };
  bench.Step(tool);
  EXPECT_TRUE(puffs().empty()) << "the pedal is not pressed";
  tool.pedal = true;
  for (int step = 0; step < 3; ++step) bench.Step(tool);
  EXPECT_EQ(puffs(), std::vector<Vector3d>(3, tool.X_WT.translation()));
  tool.X_WT.translation() += Vector3d(0.1, 0, 0);  // out of the gap
  for (int step = 0; step < 3; ++step) bench.Step(tool);
  EXPECT_LE(puffs().size(), 4) << "in the air; its last contact is known one step later";
  for (int step = 0; step < 50; ++step) bench.Step(tool);
  EXPECT_TRUE(puffs().empty()) << "after its life";
}

TEST(LayerActions, SuctionTakesTheSmokeNearItsTipWhileItsPedalIsPressed) {
  OrganBench bench;
  Bed{}.AddTo(&bench);
  bench.Start({With(ToolAction::kBurn), With(ToolAction::kSuck)});
  ToolPose hook = InGap(0.002, 0.001), tube = OrganBench::Away();
  hook.pedal = true;
  const auto puffs = [&] {
    bench.Step(std::array{hook, tube});
    bench.render->Update();
    int count = 0;
    const SceneSnapshot& scene = bench.render->Front();
    scene.smoke.ForEach(scene.step.time_ns, [&](const SmokePuff&, double) { ++count; });
    EXPECT_TRUE(scene.burns[0] == hook.pedal && !scene.burns[1] && !scene.sucks[0]);
    EXPECT_EQ(scene.sucks[1], tube.pedal);
    return count;
  };
  EXPECT_EQ(puffs(), 1);
  tube.X_WT.translation() = hook.X_WT.translation() + Vector3d(0, 0, 0.02);
  EXPECT_EQ(puffs(), 2) << "its pedal is not pressed";
  tube.pedal = true;
  EXPECT_EQ(puffs(), 0);
  tube.X_WT.translation().z() += 0.02;
  EXPECT_EQ(puffs(), 1) << "too far";
}

TEST(LayerActions, OtherInstrumentsDoNotBurnOrCut) {
  for (const ToolAction action : {ToolAction::kNone, ToolAction::kClip, ToolAction::kSuck}) {
    const Bed bed;
    OrganBench bench;
    bed.AddTo(&bench);
    bench.Start({With(action)});
    ToolPose tool = InGap(0.01, 0);
    tool.pedal = true;
    bench.Step(tool);
    tool.jaw = 0;
    bench.Step(tool);
    EXPECT_EQ(Damaged(bench), 0);
  }
}

struct CutCase {
  double jaw, y;
};
class Cutting : public testing::TestWithParam<CutCase> {};
INSTANTIATE_TEST_SUITE_P(Cases, Cutting,
                         testing::Values(CutCase{1, 0}, CutCase{0.6, 0}, CutCase{1, 0.003}));

// Blades in the plane of the layer cut what lies in the triangle between them. Their tip is beyond the
// block's edge.
TEST_P(Cutting, TakesTheTriangleBetweenTheBlades) {
  const CutCase& c = GetParam();
  const Bed bed;
  OrganBench bench;
  bed.AddTo(&bench);
  ToolOptions scissors = With(ToolAction::kCut);
  scissors.geometries[0].tip_radius = 0.004;
  bench.Start({scissors});
  ToolPose tool = InGap(-0.0245, c.y);
  tool.jaw = c.jaw;
  bench.Step(tool);
  EXPECT_EQ(Damaged(bench), 0) << "open";
  tool.jaw = 0.05;
  bench.Step(tool);
  const double height = 4 * 0.004 - 0.0045;  // from the pivot to the edge
  const double area = height * height * std::tan(c.jaw * scissors.geometries[0].opening);
  EXPECT_NEAR(ActedOutcome(bench).cut_area, area, 0.2 * area) << "whole samples";
  EXPECT_EQ(ActedOutcome(bench).cut_area, ActedOutcome(bench).freed_area);
  EXPECT_EQ(ActedOutcome(bench).burnt_area, 0);
  const double cut = ActedOutcome(bench).cut_area;
  tool.X_WT.translation().x() += 0.003;
  bench.Step(tool);
  EXPECT_EQ(ActedOutcome(bench).cut_area, cut) << "closed blades do not cut";
}

// Burnt area takes no part in the tearing: the work is the toughness times the rest.
TEST(LayerActions, ABurntShareNeedsNoWorkToTear) {
  const Bed bed{.motion_W = Vector3d(0, 0, 0.012)};
  OrganBench bench;
  bed.AddTo(&bench);
  ToolOptions hook = With(ToolAction::kBurn);
  hook.geometries[0].power = 5;
  bench.Start({hook});
  ToolPose tool = InGap(0.01, 0);
  tool.pedal = true;
  // The heat comes before the support has moved.
  bench.StayAt(0);
  for (int step = 0; step < 2; ++step) bench.Step(tool);
  const double burnt = Damaged(bench);
  ASSERT_GT(burnt, 3e-7);
  ASSERT_EQ(ActedOutcome(bench).freed_area, 0) << "in part";
  for (int step = 12; step <= 240; ++step) {
    bench.StayAt(step / 240.0);
    bench.Step();
  }
  const AttachmentOutcome& layer = ActedOutcome(bench);
  EXPECT_NEAR(layer.freed_area, bed.Area(), 1e-9);
  EXPECT_NEAR(layer.burnt_area, burnt, 1e-12);
  EXPECT_NEAR(layer.dissipated, bed.Layer().toughness * (bed.Area() - burnt), 1e-9);
}

// No tool touches the organ, so only the burning calls for a solution.
TEST(LayerActions, BurningASleepingOrganIsSeenInItsLayer) {
  Bed bed;
  OrganBench bench;
  bed.AddTo(&bench);
  bench.Start({With(ToolAction::kBurn)});
  ToolPose tool = InGap(0, 0);
  for (int step = 0; step < 3; ++step) bench.Step(tool);
  EXPECT_EQ(ActedOutcome(bench).freed_area, 0);
  tool.pedal = true;
  for (int step = 0; step < 30; ++step) bench.Step(tool);
  EXPECT_GT(ActedOutcome(bench).freed_area, 0) << "the step solved for sleeping organs";
}

// The compliance of a shaft that does not touch yet must fit to its coupling with other tools, which
// knows the burnt layer. Otherwise the tick's forces are wrong as soon as it touches.
TEST(LayerActions, AShaftBeforeItTouchesMeetsTheBurntLayer) {
  const Bed bed{.held = false};
  OrganBench bench;
  bed.AddTo(&bench);
  ToolOptions hook = With(ToolAction::kBurn), probe;
  hook.geometries[0].power = 1e6;
  probe.geometries[0] = {.tip_radius = 0.002, .shaft_radius = 0.002};
  bench.Start({hook, probe});
  // 0.3 mm above the block's top, far from what remains of the layer; its tip is beyond the edge.
  ToolPose shaft = InGap(-0.06, 0.012);
  shaft.X_WT.translation().z() = shaft.p_trocar_W.z() = 0.0123;
  const auto yields = [&] {  // m/N, down, in the block's middle
    for (int i = 0; i < 3; ++i) bench.Step(std::array{OrganBench::Away(), shaft});
    for (const ToolPatch& place : bench.patch.Front().tools[1].places) {
      if (place.organ != 1 || std::abs(place.contact_W.x()) > 1e-4) continue;
      EXPECT_EQ(place.force_on_tissue_W, Vector3d::Zero());
      return place.compliance_W(2, 2);
    }
    ADD_FAILURE() << "no place there";
    return 0.0;
  };
  const double whole = yields();
  for (double x = -0.0195; x < 0.02; x += 0.001) {
    for (double y = -0.005; y < 0.02; y += 0.001) {
      ToolPose burning = InGap(x, y);
      burning.pedal = true;
      bench.Step(std::array{burning, OrganBench::Away()});
    }
  }
  ASSERT_GT(Damaged(bench), 0.5 * bed.Area());
  EXPECT_GT(yields(), 5 * whole);
}

TEST(LayerActions, StepsThatBurnAllocateNothing) {
  if (!kCountsAllocations) GTEST_SKIP() << "the sanitizer's allocator";
  const Bed bed;
  OrganBench bench;
  bed.AddTo(&bench);
  bench.Start({With(ToolAction::kBurn)});
  ToolPose tool = InGap(0.002, 0);
  bench.Step(tool);
  tool.pedal = true;
  const long before = AllocationsOfThisThread();
  for (int step = 0; step < 9; ++step) bench.Step(tool);
  EXPECT_EQ(AllocationsOfThisThread(), before);
  EXPECT_GT(Damaged(bench), 0);
}

}  // namespace
}  // namespace hpdm
