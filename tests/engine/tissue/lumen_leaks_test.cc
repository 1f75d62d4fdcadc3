// Perforated lumens in the deformation loop: pressure and volume in time, what perforates them, and
// organs that layers hold.

#include "engine/tissue/lumen_leaks.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "engine/statics/static_loads.h"
#include "tests/support/bed_layer.h"
#include "tests/support/counted_allocations.h"
#include "tests/support/shapes.h"
#include "tools/shared/organ_bench.h"

namespace hpdm {
namespace {

constexpr double kOuterRadius = 0.03, kInnerRadius = 0.026, kTip = 0.001;  // m

// A hollow ball of 20 kPa with fluid, whose lowest part is held.
struct FullBall {
  double pressure = 1000;       // Pa
  double resistance = 4e8;      // Pa s/m^3
  double bulk_modulus = 2.2e9;  // Pa
  std::optional<double> perforated_at = {};
  bool filled = true;
  bool held = true;
  double share = 0;                 // of a Prony term
  std::optional<double> drag = {};  // 1/s, of a free ball

  OrganModel Model() const {
    OrganOptions ball;
    ball.name = "ball";
    ball.material = {.young = 2e4, .poisson = 0.45};
    if (share > 0) {
      ball.material.prony.count = 1;
      ball.material.prony.terms[0] = {share, 1};
    }
    ball.lattice.cells = {5, 5, 5};
    ball.lattice.margin = 0.0005;
    ball.lattice.local.functions = 0;
    if (drag) ball.free = FreeOptions{.drag = *drag};
    if (held && !drag)
      ball.supports.push_back({BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.15)}, {}});
    ball.lumens = {{.region = {},
                    .filled = filled,
                    .bulk_modulus = bulk_modulus,
                    .pressure = pressure,
                    .leak_resistance = resistance,
                    .perforated_at = perforated_at}};
    return {ball, HollowBall()};
  }
  static SurfaceMesh HollowBall() {
    SurfaceMesh both = Ellipsoid(Vector3d::Constant(kOuterRadius), 3);
    const SurfaceMesh inner = Ellipsoid(Vector3d::Constant(kInnerRadius), 3);
    const Eigen::Index vertices = inner.vertices.rows(), triangles = inner.triangles.rows();
    both.vertices.conservativeResize(2 * vertices, 3);
    both.vertices.bottomRows(vertices) = inner.vertices;
    both.triangles.conservativeResize(2 * triangles, 3);
    both.triangles.bottomRows(triangles) = inner.triangles.array() + static_cast<int>(vertices);
    both.triangles.bottomRows(triangles).col(1).swap(both.triangles.bottomRows(triangles).col(2));
    return both;
  }
  void AddTo(OrganBench* bench) const {
    const OrganModel model = Model();
    bench->Add(model.options(), HollowBall());
  }
};

const LumenOutcome& LumenOf(const OrganBench& bench) { return bench.organ(0).leaks.outcomes()[0]; }

// m^3: change of the cavity by displacements of the vertices, to first order.
double Grown(const OrganModel& ball, const Points& moved) {
  const SurfaceMesh& rest = ball.rest();
  double grown = 0;
  for (Eigen::Index t = rest.triangles.rows() / 2; t < rest.triangles.rows(); ++t) {
    const Vector3d normal = TwiceAreaNormal(rest.vertices, rest.triangles, t) / 2;
    for (int c = 0; c < 3; ++c) grown -= normal.dot(moved.row(rest.triangles(t, c))) / 3;
  }
  return grown;
}

// m^3/Pa: of the empty ball under a pressure on its inner wall.
double WallCompliance() {
  const OrganModel ball = FullBall{.filled = false}.Model();
  LoadOptions load;
  load.organ = "ball";
  load.pressure = 1;
  load.region = Sphere{Vector3d::Zero(), (kInnerRadius + kOuterRadius) / 2};
  return Grown(ball, StaticLoads(ball, {load}).Solve().vertex_displacements);
}

TEST(LumenLeaks, PressureFallsAsThatOfACapacitorAndTheVolumeWithIt) {
  const double compliance = WallCompliance();
  for (const double resistance : {4e8, 4e9}) {
    const FullBall ball{.resistance = resistance, .perforated_at = 0.49};
    OrganBench bench;
    ball.AddTo(&bench);
    bench.Start();
    for (int step = 0; step < 15; ++step) bench.Step();
    EXPECT_FALSE(LumenOf(bench).perforated);
    EXPECT_EQ(LumenOf(bench).pressure, ball.pressure);
    EXPECT_FALSE(bench.organ(0).awake);
    const double time = resistance * compliance;
    for (int step = 1; step <= 200; ++step) {
      bench.Step();
      EXPECT_TRUE(LumenOf(bench).perforated);
      const double share = std::exp(-step / 30.0 / time);
      ASSERT_NEAR(LumenOf(bench).pressure, share * ball.pressure, 0.02 * ball.pressure) << step;
      const double lost = compliance * ball.pressure * (1 - share);
      ASSERT_NEAR(LumenOf(bench).lost, lost, 0.02 * compliance * ball.pressure) << step;
      const Points moved = bench.organ(0).vertices - bench.model(0).rest().vertices;
      ASSERT_NEAR(-Grown(bench.model(0), moved), LumenOf(bench).lost,
                  1e-3 * compliance * ball.pressure)
          << step;
    }
  }
}

// m^3: of the cavity, which is the second half of the triangles, as it is.
double CavityOf(const OrganBench& bench) {
  const SurfaceMesh& rest = bench.model(0).rest();
  const Points& now = bench.organ(0).vertices;
  double six_volumes = 0;
  for (Eigen::Index t = rest.triangles.rows() / 2; t < rest.triangles.rows(); ++t) {
    const Vector3d a = now.row(rest.triangles(t, 0)), b = now.row(rest.triangles(t, 1)),
                   c = now.row(rest.triangles(t, 2));
    six_volumes -= a.dot(b.cross(c));
  }
  return six_volumes / 6;
}

// Lame's thick sphere: the inner wall moves by (p a / E) (((1 - 2 nu) a^3 + (1 + nu) b^3 / 2) / (b^3 - a^3)).
double SphereCompliance() {
  const double a = kInnerRadius, b = kOuterRadius, young = 2e4, poisson = 0.45;
  const double a3 = a * a * a, b3 = b * b * b;
  const double moved = a / young * ((1 - 2 * poisson) * a3 + (1 + poisson) * b3 / 2) / (b3 - a3);
  return 4 * std::numbers::pi * a * a * moved;
}

// Jaws swing it first and let it go, so that it turns and flies.
TEST(LumenLeaks, AFreeOrganLosesTheSameInFlight) {
  OrganBench bench;
  const FullBall ball{.pressure = 100, .perforated_at = 0.49, .drag = 0.1};
  ball.AddTo(&bench);
  ToolOptions grasper;
  grasper.geometries[0].can_grasp = true;
  bench.Start({grasper});
  ToolPose jaws = OrganBench::Above(Vector3d(0, 0, kOuterRadius));
  for (int step = 0; step < 10; ++step) {
    jaws.jaw = step < 2 ? 1 : 0.05;
    jaws.X_WT.translation() += Vector3d(0.003, 0, 0) * (step < 3 ? 0 : 1);
    bench.Step(jaws);
  }
  for (int step = 10; step < 15; ++step) bench.Step();
  const double full = CavityOf(bench);
  const Vector3d from_W = bench.organ(0).vertices.colwise().mean();
  const Matrix3d turned_from = bench.organ(0).relaxation->Rotation();
  const double time = ball.resistance * SphereCompliance();
  for (int step = 1; step <= 200; ++step) {
    bench.Step();
    ASSERT_TRUE(LumenOf(bench).perforated);
    const double share = std::exp(-step / 30.0 / time);
    ASSERT_NEAR(LumenOf(bench).pressure, share * ball.pressure, 0.05 * ball.pressure) << step;
    ASSERT_NEAR(full - CavityOf(bench), LumenOf(bench).lost,
                0.02 * SphereCompliance() * ball.pressure)
        << step;
  }
  const Vector3d way_W = bench.organ(0).vertices.colwise().mean().transpose() - from_W;
  EXPECT_GT(way_W.norm(), 0.1) << "it flew";
  const Matrix3d turn = bench.organ(0).relaxation->Rotation() * turned_from.transpose();
  EXPECT_GT(Eigen::AngleAxisd(turn).angle(), 0.5) << "and turned";
}

TEST(LumenLeaks, AClosedLumenKeepsItsVolumeUnderAPress) {
  for (const bool leaks : {false, true}) {
    FullBall ball{.pressure = 0};
    if (leaks) ball.perforated_at = 0;
    OrganBench bench;
    ball.AddTo(&bench);
    bench.Start();
    const double volume = 4 * std::numbers::pi / 3 * std::pow(kInnerRadius, 3);
    const auto press = [&](double depth) {
      bench.Step(OrganBench::Above(Vector3d(0, 0, kOuterRadius + kDefaultToolRadius - depth)));
    };
    for (int step = 0; step < 60; ++step) press(std::min(0.003, 0.0005 * step));
    const Points moved = bench.organ(0).vertices - bench.model(0).rest().vertices;
    const double grown = Grown(bench.model(0), moved);
    if (!leaks) {
      EXPECT_LT(std::abs(grown), 1e-6 * volume);
      EXPECT_GT(LumenOf(bench).pressure, 1);
      EXPECT_EQ(LumenOf(bench).lost, 0);
      continue;
    }
    EXPECT_LT(grown, -1e-4 * volume);
    EXPECT_NEAR(LumenOf(bench).lost, -grown, 1e-3 * std::abs(grown));
    // Gas enters, and the wall springs back.
    for (int step = 0; step < 1500; ++step) bench.Step();
    EXPECT_NEAR(LumenOf(bench).lost, 0, 0.01 * std::abs(grown));
  }
}

// A wide hole: the steps are much longer than the leak.
TEST(LumenLeaks, AWideHoleDoesNotSwing) {
  const FullBall ball{.resistance = 1, .perforated_at = 0};
  OrganBench bench;
  ball.AddTo(&bench);
  bench.Start();
  double last = ball.pressure;
  for (int step = 0; step < 60; ++step) {
    bench.Step();
    EXPECT_GE(LumenOf(bench).pressure, -1e-2) << step;
    EXPECT_LE(LumenOf(bench).pressure, last) << step;
    last = LumenOf(bench).pressure;
  }
  EXPECT_LT(last, 1);
}

// A tool whose tip presses the top of the ball by `depth` (m), or is above it.
ToolPose PressingTip(double jaw, bool pedal, double depth = 0.001) {
  ToolPose tool = OrganBench::Above(Vector3d(0, 0, kOuterRadius + kTip - depth));
  tool.jaw = jaw;
  tool.pedal = pedal;
  return tool;
}

// Returns the number of the step, from the third, that perforates the ball; 100: none.
int PerforatedIn(const ToolGeometry& geometry, bool pedal, double depth = 0.001) {
  OrganBench bench;
  FullBall().AddTo(&bench);
  ToolOptions tool;
  tool.geometries[0] = geometry;
  tool.geometries[0].tip_radius = tool.geometries[0].shaft_radius = kTip;
  bench.Start({tool});
  for (int step = 0; step < 2; ++step) bench.Step(PressingTip(1, false, depth));
  for (int step = 1; step < 100; ++step) {
    bench.Step(PressingTip(step < 10 ? 1 : 0.05, pedal, depth));
    if (LumenOf(bench).perforated) return step;
  }
  return 100;
}

TEST(WallActions, AHookBurnsAHoleByItsHeatAndScissorsCutOne) {
  for (const double power : {20.0, 40.0}) {
    const double heat =
        WallActions::kBurning * WallActions::kHoleArea * (kOuterRadius - kInnerRadius);
    const int expected = static_cast<int>(std::ceil(heat / (power / 30)));
    const int step = PerforatedIn({.action = ToolAction::kBurn, .power = power}, true);
    // The tip's dent and the facets make the wall thinner.
    EXPECT_LE(step, expected) << power;
    EXPECT_GE(step, 0.85 * expected) << power;
  }
  EXPECT_EQ(PerforatedIn({.action = ToolAction::kCut}, false), 10);
}

TEST(WallActions, NothingElsePerforates) {
  EXPECT_EQ(PerforatedIn({.action = ToolAction::kBurn}, false), 100);
  EXPECT_EQ(PerforatedIn({}, true), 100);
  EXPECT_EQ(PerforatedIn({.can_grasp = true}, true), 100);
  EXPECT_EQ(PerforatedIn({.action = ToolAction::kClip, .clips = 3}, true), 100);
  // A tip above the wall.
  EXPECT_EQ(PerforatedIn({.action = ToolAction::kCut}, false, -0.0005), 100);
  EXPECT_EQ(PerforatedIn({.action = ToolAction::kBurn, .power = 40}, true, -0.0005), 100);
}

TEST(LumenLeaks, ViscoelasticTissueKeepsItsLumensClosed) {
  OrganBench bench;
  FullBall{.perforated_at = 0, .share = 0.3}.AddTo(&bench);
  bench.Start();
  for (int step = 0; step < 10; ++step) bench.Step();
  EXPECT_FALSE(LumenOf(bench).perforated);
}

// The ball's layer on a rigid plate and its whole stiffness, solved at once.
void ExpectEquilibriumWithALayer(const FullBall& ball) {
  OrganBench bench;
  ball.AddTo(&bench);
  OrganOptions plate;
  plate.name = "plate";
  plate.model = OrganModelType::kRigid;
  bench.Add(plate,
            GridBox(Vector3d(-0.03, -0.03, kOuterRadius), Vector3d(0.03, 0.03, 0.04), {24, 24, 4}));
  AttachmentOptions layer =
      BedLayer("ball", "plate", hpdm::Box{Vector3d(-1, -1, 0), Vector3d(1, 1, 1)}, 0.003);
  layer.strength = 1e6;
  layer.toughness = 1e5;
  bench.Attach(layer);
  bench.Start();
  for (int step = 0; step < 100; ++step) bench.Step();
  const double lost = LumenOf(bench).lost;
  ASSERT_GT(lost, 0);
  const OrganModel& model = bench.model(0);
  FullStiffness K = std::get<FullStiffness>(model.stiffness());
  if (ball.drag) {  // it holds the inertia of a step, too
    FullStiffness inertia = FullStiffness::Zero(K.rows(), K.cols());
    const FreeFlight flight(model.options().time_step, *ball.drag, Vector3d::Zero());
    model.free_body()->AddInertia(flight.Yield(), &inertia);
    K -= inertia;
  }
  const AttachmentBed& bed = bench.loop().links()[0].joint().layers()[0].bed;
  const Eigen::MatrixXd rows = bed.rows[0];
  const Eigen::MatrixXd held = bed.law.stiffness * rows.transpose() * bed.areas.asDiagonal() * rows;
  for (int d = 0; d < 3; ++d) {
    for (Eigen::Index a = 0; a < held.rows(); ++a) {
      for (Eigen::Index b = 0; b < held.cols(); ++b) K(3 * a + d, 3 * b + d) += held(a, b);
    }
  }
  const FillingsAndLayers& surface = model.lattice_organ()->fillings_and_layers();
  const Lumen& lumen = surface.lumens()[0];
  const Eigen::VectorXd f =
      -lost * std::sqrt(lumen.bulk_modulus / lumen.volume) *
      surface.FillingRows(model.lattice_organ()->lattice()).row(0).transpose();
  const Eigen::VectorXd expected = K.llt().solve(f);
  const Points& U = bench.organ(0).control_displacements;
  const Eigen::Map<const Eigen::VectorXd> u(U.data(), U.size());
  EXPECT_LT((u - expected).norm(), 0.005 * expected.norm());
  EXPECT_GT(expected.norm(), 1e-4);
}

TEST(LumenLeaks, AnAttachedOrganIsInEquilibriumWithItsLayer) {
  ExpectEquilibriumWithALayer({.perforated_at = 0});
}

// Only the layer holds it. The drag ends its motion.
TEST(LumenLeaks, AFreeOrganIsInEquilibriumWithItsLayer) {
  ExpectEquilibriumWithALayer({.perforated_at = 0, .drag = 20});
}

TEST(LumenLeaks, ACopyLeaksToTheLastBitAndNothingIsAllocated) {
  OrganBench bench;
  FullBall{.perforated_at = 0.2}.AddTo(&bench);
  bench.Start();
  bench.Step(PressingTip(1, false));
  const long before = AllocationsOfThisThread();
  for (int step = 0; step < 20; ++step) bench.Step(PressingTip(1, false));
  if (kCountsAllocations) {
    EXPECT_EQ(AllocationsOfThisThread(), before);
  }
  TripleBuffer<ToolState> edge;
  TripleBuffer<ContactPatch> patch;
  TripleBuffer<SceneSnapshot> render, telemetry;
  DeformationLoop copy = bench.loop();
  copy.Attach({edge, patch, render, telemetry});
  ToolState tools;
  tools.tool_count = 1;
  for (int step = 0; step < 10; ++step) {
    const auto now =
        static_cast<Nanoseconds>(std::llround(bench.seconds() * kNanosecondsPerSecond));
    bench.Step(PressingTip(1, false));
    tools.tick = static_cast<std::uint64_t>(step) + 22;
    tools.time_ns = now;
    tools.tools[0] = PressingTip(1, false);
    copy.Step(tools, now);
    ASSERT_EQ(copy.organ(0).control_displacements, bench.organ(0).control_displacements) << step;
  }
  EXPECT_GT(LumenOf(bench).lost, 0);
}

}  // namespace
}  // namespace hpdm
