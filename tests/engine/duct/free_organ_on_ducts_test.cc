// A free organ on a bed and on ducts: it hangs on both, on the ducts alone, and falls once nothing holds
// it. Its stumps go with it.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "tests/support/bed_layer.h"
#include "tests/support/counted_allocations.h"
#include "tests/support/shapes.h"
#include "tools/shared/organ_bench.h"

namespace hpdm {
namespace {

constexpr double kG = 9.81;        // m/s^2
constexpr double kDensity = 1060;  // kg/m^3
constexpr double kDt = 1.0 / 30;   // s
constexpr double kGap = 0.0003;    // m, between plate and block
constexpr double kThin = 1e-4;     // m: a hook that fits into the gap
const Vector3d kSides(0.03, 0.03, 0.02);

// A block beside a rigid plate whose face is at x = 0. A layer holds its side, and two ducts above its
// centre lead upwards to the world.
struct BlockOnDucts {
  double scale = 1;  // of all lengths
  std::array<int, 3> cells = {3, 3, 3};
  double drag = 3;          // 1/s
  double wall_young = 3e5;  // Pa
  double duct_length = 0.03;

  double Weight() const { return kDensity * std::pow(scale, 3) * kSides.prod() * kG; }
  double Axial() const {
    const DuctOptions duct = Duct(0);
    return TubeSection(duct.young, duct.radius, duct.wall, kDuctPoisson).axial;
  }
  Vector3d End(int number) const {
    return scale * Vector3d(kGap + kSides.x() / 2, number == 0 ? -0.008 : 0.008, kSides.z() / 2);
  }
  DuctOptions Duct(int number) const {
    DuctOptions duct;
    duct.name = number == 0 ? "first" : "second";
    duct.a = "block";
    duct.path_W.resize(2, 3);
    duct.path_W.row(0) = End(number).transpose();
    duct.path_W.row(1) = (End(number) + scale * Vector3d(0, 0, duct_length)).transpose();
    duct.radius = 0.002 * scale;
    duct.wall = 0.0008 * scale;
    duct.young = wall_young;
    return duct;
  }
  void Start(OrganBench* bench) const {
    OrganOptions plate;
    plate.name = "plate";
    plate.model = OrganModelType::kRigid;
    plate.gravity_W = Vector3d(0, 0, -kG);
    bench->Add(plate, GridBox(Vector3d(-0.01, -0.04, -0.04) * scale,
                              Vector3d(0, 0.04, 0.04) * scale, {2, 24, 24}));
    OrganOptions block;
    block.name = "block";
    block.material = {.young = 3e6 * scale, .poisson = 0.3};
    block.material.density = kDensity;
    block.lattice.cells = cells;
    block.lattice.margin = 0.0005 * scale;
    block.lattice.local.functions = 0;
    block.gravity_W = plate.gravity_W;
    block.free = FreeOptions{drag};
    const Vector3d low(kGap, -kSides.y() / 2, -kSides.z() / 2);
    bench->Add(block, GridBox(low * scale, (low + kSides) * scale, {10, 10, 8}));
    AttachmentOptions layer = BedLayer(
        "block", "plate", hpdm::Box{Vector3d(-1, -1, -1), Vector3d(1, 1, 1)}, 0.001 * scale);
    layer.thickness *= scale;
    layer.toughness *= scale;
    bench->Attach(layer);
    for (int number = 0; number < 2; ++number) bench->Join(Duct(number));
    ToolOptions first, second;
    first.geometries.assign(3, {});
    first.geometries[0] = {.tip_radius = kThin * scale,
                           .shaft_radius = kThin * scale,
                           .action = ToolAction::kBurn,
                           .power = 1e9};  // burns all that it reaches in one step
    first.geometries[1] = {.tip_radius = 0.0025 * scale, .action = ToolAction::kCut};
    first.geometries[2] = {.tip_radius = 0.0025 * scale, .can_grasp = true};
    second.geometries = {first.geometries[1], first.geometries[0]};
    bench->Start({first, second});
  }

  // A hook in the gap.
  ToolPose Hook(double y, double z, int instrument = 0) const {
    ToolPose tool;
    tool.instrument_index = instrument;
    tool.X_WT.translation() = scale * Vector3d(kGap / 2, y, z);
    tool.p_trocar_W = tool.X_WT.translation() + Vector3d(0, 0, 0.3);
    tool.pedal = true;
    return tool;
  }
  // Jaws across a duct at a height on it (m), from +x.
  ToolPose Jaws(int duct, double height, double jaw, int instrument) const {
    ToolPose tool;
    tool.X_WT.linear() << 0, 0, 1, 1, 0, 0, 0, 1, 0;  // x_T = y, y_T = z, z_T = x
    tool.X_WT.translation() = End(duct) + scale * Vector3d(-0.005, 0, height);
    tool.p_trocar_W = tool.X_WT * Vector3d(0, 0, 0.3);
    tool.jaw = jaw;
    tool.instrument_index = instrument;
    return tool;
  }
};

ToolPose None(int instrument = 0) {
  ToolPose tool = OrganBench::Away();
  tool.instrument_index = instrument;
  return tool;
}

void Wait(OrganBench* bench, int steps) {
  for (int k = 0; k < steps; ++k) bench->Step(std::array{None(), None()});
}

const AttachmentLink& LinkOf(const OrganBench& bench) { return bench.loop().links()[0]; }
const DuctState& DuctOf(const OrganBench& bench, int number) {
  return LinkOf(bench).state().ducts()[ToSize(number)];
}
bool IsFree(const OrganBench& bench) {
  return LinkOf(bench).HasLetGo(ToSize(LinkOf(bench).joint().MemberOf(1)));
}
Vector3d Centre(const OrganBench& bench) {
  const FreeBody& body = *bench.model(1).free_body();
  const Points U = bench.organ(1).control_displacements.topRows(body.masses.size());
  return body.p_centre_W + U.transpose() * body.masses / body.mass;
}

// Burns the whole bed by the first tool, or by the second one while the first stays. The hook then goes
// upwards out of the gap. `way`: takes how far the step that lets go moves the organ, m.
void BurnBed(const BlockOnDucts& block, OrganBench* bench, const ToolPose* first = nullptr,
             double* way = nullptr) {
  const auto step = [&](double y, double z) {
    const bool was_free = IsFree(*bench);
    const Points before = way == nullptr ? Points() : bench->organ(1).vertices;
    bench->Step(first == nullptr ? std::array{block.Hook(y, z), None()}
                                 : std::array{*first, block.Hook(y, z, 1)});
    if (way == nullptr || was_free || !IsFree(*bench)) return;
    *way = (bench->organ(1).vertices - before).rowwise().norm().maxCoeff();
  };
  const double apart = 0.002 / block.scale;  // heat reaches a millimetre at any scale
  for (double y = -0.0145; y < 0.015; y += apart) {
    for (double z = -0.0095; z < 0.01; z += apart) {
      step(y, z);
    }
  }
  for (int k = 1; k <= 10; ++k) step(0.0135, 0.0085 + 0.004 * k);
  ASSERT_TRUE(LinkOf(*bench).state().IsTorn(0));
}

// Cuts one duct, or both in one step, in their middle.
void CutDucts(const BlockOnDucts& block, bool both, OrganBench* bench) {
  const double middle = block.duct_length / 2;
  for (const double jaw : {1.0, 0.05}) {
    bench->Step(
        std::array{block.Jaws(0, middle, jaw, 1), both ? block.Jaws(1, middle, jaw, 0) : None()});
  }
  ASSERT_EQ(DuctOf(*bench, 0).Outcome().cuts, 1);
  ASSERT_EQ(DuctOf(*bench, 1).Outcome().cuts, both ? 1 : 0);
}

class FreeOrganOnDucts : public testing::TestWithParam<BlockOnDucts> {};
INSTANTIATE_TEST_SUITE_P(Cases, FreeOrganOnDucts,
                         testing::Values(BlockOnDucts{}, BlockOnDucts{.cells = {4, 4, 3}},
                                         BlockOnDucts{.scale = 2.5, .drag = 1}));

TEST_P(FreeOrganOnDucts, HangsStillAndItsLayerBearsTheWholeWeight) {
  const BlockOnDucts& block = GetParam();
  OrganBench bench;
  block.Start(&bench);
  const Points rest = bench.organ(1).vertices;
  Wait(&bench, 90);
  EXPECT_LT((bench.organ(1).vertices - rest).cwiseAbs().maxCoeff(), 1e-8 * block.scale);
  const Vector3d load_W = LinkOf(bench).outcomes()[0].load_W;
  EXPECT_LT((load_W + Vector3d(0, 0, block.Weight())).norm(), 2e-3 * block.Weight());
  for (int d = 0; d < 2; ++d) EXPECT_LT(DuctOf(bench, d).Outcome().tension, 1e-6);
  EXPECT_FALSE(IsFree(bench));
}

// Each duct bears half the weight and stretches by F L / (E A).
TEST_P(FreeOrganOnDucts, HangsOnItsDuctsOnceItsBedIsBurnt) {
  const BlockOnDucts& block = GetParam();
  OrganBench bench;
  block.Start(&bench);
  const Vector3d from = Centre(bench);
  BurnBed(block, &bench);
  Wait(&bench, 300);
  EXPECT_TRUE(IsFree(bench));
  const double half = block.Weight() / 2;
  for (int d = 0; d < 2; ++d) {
    EXPECT_NEAR(DuctOf(bench, d).Outcome().tension, half, 0.01 * half) << d;
    EXPECT_LT((DuctOf(bench, d).Outcome().load_W + Vector3d(0, 0, half)).norm(), 0.01 * half);
  }
  const double sunk = half * block.scale * block.duct_length / block.Axial();
  const Vector3d way = Centre(bench) - from;
  EXPECT_NEAR(-way.z(), sunk, 0.02 * sunk);
  EXPECT_LT(way.head<2>().norm(), 0.02 * sunk);
}

// Returns how far a body at rest falls in t, m.
double Fall(double drag, double t) { return kG / drag * (t + std::expm1(-drag * t) / drag); }

TEST_P(FreeOrganOnDucts, FallsWithDragOnceItsDuctsAreCutToo) {
  const BlockOnDucts& block = GetParam();
  OrganBench bench;
  block.Start(&bench);
  BurnBed(block, &bench);
  Wait(&bench, 300);
  CutDucts(block, true, &bench);
  EXPECT_TRUE(IsFree(bench));
  // The weight acts from the step in which the ducts are cut, and that step moves it by g dt^2.
  std::vector<double> heights;
  for (int k = 0; k < 20; ++k) {
    heights.push_back(Centre(bench).z());
    bench.Step(std::array{None(1), None()});
  }
  const double speed = (heights[0] - heights[1] - Fall(block.drag, kDt)) * block.drag /
                       -std::expm1(-block.drag * kDt);
  EXPECT_NEAR(speed, kG * kDt, 0.1 * kG * kDt);
  for (std::size_t k = 2; k < heights.size(); ++k) {
    const double t = static_cast<double>(k) * kDt;
    const double fallen = Fall(block.drag, t) + speed * -std::expm1(-block.drag * t) / block.drag;
    EXPECT_NEAR(heights[0] - heights[k], fallen, 0.01 * fallen) << k;
  }
  EXPECT_LT(heights.back(), -0.5 * kG * 0.25) << "it is far below";
}

// The stump on the body keeps its shape in the body's frame; the other one stays.
TEST_P(FreeOrganOnDucts, StumpsStayOnWhatHoldsThem) {
  const BlockOnDucts& block = GetParam();
  OrganBench bench;
  block.Start(&bench);
  // A duct that is cut first makes it swing: it turns as it falls.
  CutDucts(block, false, &bench);
  BurnBed(block, &bench);
  const double high = 0.9 * block.duct_length;
  for (const double jaw : {1.0, 0.05}) {
    bench.Step(std::array{None(1), block.Jaws(1, high, jaw, 0)});
  }
  ASSERT_TRUE(IsFree(bench));
  for (int k = 0; k < 30; ++k) {
    bench.Step(std::array{None(1), None()});
    const FreeBody& body = *bench.model(1).free_body();
    const Matrix3d R = bench.organ(1).relaxation->Rotation();
    const Vector3d p_W = Centre(bench);
    for (int d = 0; d < 2; ++d) {
      const Rod& rod = DuctOf(bench, d).rod();
      const Rod& rest = DuctOf(bench, d).model().rod;
      for (int i = 0; rod.IsSegment(i); ++i) {
        const Vector3d expected = p_W + R * (rest.node(i) - body.p_centre_W);
        ASSERT_LT((rod.node(i) - expected).norm(), 2e-5 * block.scale) << k << ' ' << d << ' ' << i;
      }
      EXPECT_LT(DuctOf(bench, d).Outcome().tension, 1e-5);
    }
  }
  EXPECT_GT(RotationVector(bench.organ(1).relaxation->Rotation()).norm(), 0.1) << "it turns";
  for (int d = 0; d < 2; ++d) {
    const Rod& rod = DuctOf(bench, d).rod();
    const Rod& rest = DuctOf(bench, d).model().rod;
    for (int i = 0; rod.IsSegment(rod.nodes() - 2 - i); ++i) {
      const Vector3d expected = rest.node(rest.nodes() - 1 - i);
      EXPECT_LT((rod.node(rod.nodes() - 1 - i) - expected).norm(), 2e-5 * block.scale) << d << i;
    }
  }
}

// Jaws that hold a stump hold the organ: it hangs on them, and falls once they open.
TEST(FreeOrganOnDuct, HangsOnJawsThatHoldItsStump) {
  const BlockOnDucts block;
  OrganBench bench;
  block.Start(&bench);
  const double low = 0.010, high = 0.022;  // m, on the ducts
  bench.Step(std::array{block.Jaws(1, low, 1, 2), None()});
  const ToolPose jaws = block.Jaws(1, low, 0.05, 2);
  bench.Step(std::array{jaws, None()});
  for (int d = 0; d < 2; ++d) {
    for (const double jaw : {1.0, 0.05}) bench.Step(std::array{jaws, block.Jaws(d, high, jaw, 0)});
    ASSERT_EQ(DuctOf(bench, d).Outcome().cuts, 1);
  }
  EXPECT_FALSE(IsFree(bench));
  double way = 0;
  BurnBed(block, &bench, &jaws, &way);
  EXPECT_GT(way, 0);
  EXPECT_LT(way, 0.06) << "it swings, but is not thrown back to where it lay";
  for (int k = 0; k < 300; ++k) bench.Step(std::array{jaws, None(1)});
  EXPECT_TRUE(IsFree(bench));
  const Vector3d force_W = bench.patch.Front().tools[0].main().force_on_tissue_W;
  EXPECT_LT((force_W - Vector3d(0, 0, block.Weight())).norm(), 0.01 * block.Weight());
  const double height = Centre(bench).z();
  for (int k = 0; k < 15; ++k) bench.Step(std::array{None(2), None(1)});
  EXPECT_LT(Centre(bench).z(), height - 0.5);
  EXPECT_LT(DuctOf(bench, 1).Outcome().tension, 1e-5);
}

TEST(FreeOrganOnDuct, ACopyFallsToTheLastBitAndNothingIsAllocated) {
  const BlockOnDucts block;
  OrganBench bench;
  block.Start(&bench);
  CutDucts(block, true, &bench);
  const DeformationLoop copied = bench.loop();
  const long before = AllocationsOfThisThread();
  BurnBed(block, &bench);
  Wait(&bench, 5);
  if (kCountsAllocations) {
    EXPECT_EQ(AllocationsOfThisThread(), before);
  }
  ASSERT_TRUE(IsFree(bench));
  DeformationLoop copy(copied);
  TripleBuffer<ToolState> edge;
  TripleBuffer<ContactPatch> patch;
  TripleBuffer<SceneSnapshot> render, telemetry;
  copy.Attach({edge, patch, render, telemetry});
  Nanoseconds now = 2 * OrganBench::kPeriod;
  ToolState tools;
  tools.tick = 2;
  tools.tool_count = 2;
  const auto step = [&](const ToolPose& first) {
    ++tools.tick;
    tools.time_ns = now;
    tools.tools[0] = first;
    tools.tools[1] = None();
    copy.Step(tools, now);
    now += OrganBench::kPeriod;
  };
  for (double y = -0.0145; y < 0.015; y += 0.002) {
    for (double z = -0.0095; z < 0.01; z += 0.002) step(block.Hook(y, z));
  }
  for (int k = 1; k <= 10; ++k) step(block.Hook(0.0135, 0.0085 + 0.004 * k));
  for (int k = 0; k < 5; ++k) step(None());
  EXPECT_EQ(copy.organ(1).control_displacements, bench.organ(1).control_displacements);
  const Rod& theirs = copy.links()[0].state().ducts()[0].rod();
  for (int i = 0; i < theirs.nodes(); ++i) {
    ASSERT_EQ(theirs.node(i), DuctOf(bench, 0).rod().node(i)) << i;
  }
}

}  // namespace
}  // namespace hpdm
