// Tests an organ that does not deform: the hand feels a virtual wall, and nothing moves.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "engine/base/error.h"
#include "tests/support/felt_bench.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

const Vector3d kRadii(0.1, 0.07, 0.05);  // m, half, of the ellipsoid; its top is a vertex
constexpr double kWall = 300;            // N/m

OrganOptions Rigid() {
  OrganOptions options;
  options.name = "rigid";
  options.model = OrganModelType::kRigid;
  return options;
}

ToolOptions Tool(double radius = 0.0025) {
  ToolOptions tool;
  tool.geometries[0].tip_radius = radius;
  tool.wall_stiffness = kWall;
  return tool;
}

// Moves the tip in a session from `gap` above the top of the ellipsoid down to `depth` at 0.05 m/s.
ToolPose Press(FeltBench* bench, double radius, double depth) {
  ToolPose tool;
  for (double z = -0.003; z <= depth + 1e-9; z += 5e-5) {
    tool = FeltBench::At(Vector3d(0, 0, kRadii.z() + radius - z));
    bench->SessionTick(tool);
  }
  return tool;
}

TEST(RigidOrgan, ForceIsTheWallsStiffnessTimesTheDepth) {
  for (const double radius : {0.0, 0.0025, 0.005}) {
    for (const ReactionType reaction : {ReactionType::kLattice, ReactionType::kPaper}) {
      ToolOptions tool = Tool(radius);
      tool.reaction = reaction;
      FeltBench bench(Rigid(), Ellipsoid(kRadii, 3), tool);
      for (const double depth : {0.001, 0.01}) {
        Press(&bench, radius, depth);
        // At the top the normal is vertical by symmetry, but for the fit of the normals (1e-4 rad).
        EXPECT_NEAR(bench.Hand().z(), kWall * depth, 1e-7 * kWall * depth)
            << radius << ' ' << depth;
        EXPECT_LT(bench.Hand().head<2>().norm(), 2e-4 * kWall * depth);
        EXPECT_NEAR(bench.Felt().depth, depth, 1e-7 * depth);
        // The last step's state is that of a tip up to 66 ticks ago: 3.3 mm higher.
        const ToolPatch& patch = bench.Patch();
        EXPECT_EQ(patch.reaction, ReactionType::kLattice);
        EXPECT_EQ(patch.compliance_W, Matrix3d(Matrix3d::Identity() / kWall));
        EXPECT_NEAR((patch.p_original_W - Vector3d(0, 0, kRadii.z())).norm(), 0, 2e-6);
      }
    }
  }
}

TEST(RigidOrgan, OpenSurfaceIsRefused) {
  SurfaceMesh open = Ellipsoid(kRadii, 3);
  open.triangles.conservativeResize(open.triangles.rows() - 1, 3);
  EXPECT_THROW(OrganModel(Rigid(), open), InputError);
}

TEST(RigidOrgan, OwnWallStiffnessGoesBeforeTheTools) {
  OrganOptions options = Rigid();
  options.wall_stiffness = 150;
  FeltBench bench(options, Ellipsoid(kRadii, 3), Tool());
  Press(&bench, 0.0025, 0.01);
  EXPECT_NEAR(bench.Hand().z(), 1.5, 1e-7);  // the fit of the normals, as above
}

TEST(RigidOrgan, StepMovesNothing) {
  const SurfaceMesh rest = Ellipsoid(kRadii, 3);
  const std::vector<OrganModel> organs = OneOrgan(Rigid(), rest);
  EXPECT_EQ(organs[0].control_points(), 0);
  EXPECT_TRUE(organs[0].warnings().empty());
  TripleBuffer<ToolState> tools;
  TripleBuffer<ContactPatch> patches;
  TripleBuffer<SceneSnapshot> render{SizedSnapshot(organs, 1, true)};
  TripleBuffer<SceneSnapshot> telemetry{SizedSnapshot(organs, 1, false)};
  DeformationLoop loop(organs, {Tool()}, {tools, patches, render, telemetry});
  ToolState state;
  state.tool_count = 1;
  state.tools[0] = FeltBench::At(Vector3d(0, 0, kRadii.z() - 0.01));
  for (int i = 0; i < 3; ++i) loop.Step(state, i * 33'000'000);
  patches.Update();
  render.Update();
  EXPECT_GT(patches.Front().tools[0].main().force_on_tissue_W.norm(), 1);
  EXPECT_EQ(loop.record().flags, kStepOk);
  EXPECT_EQ(loop.record().residual, 0);
  EXPECT_EQ(loop.organ(0).vertices, rest.vertices);
  const OrganSnapshot& shape = render.Front().organs[0];
  EXPECT_EQ(shape.control_displacements.rows(), 0);
  EXPECT_EQ(shape.indentation_count, 0);
  EXPECT_EQ(shape.vertices, rest.vertices.cast<float>());
}

TEST(RigidOrgan, SlideOverTheEdgesOfACoarseSphereTurnsTheForceSmoothly) {
  // 320 triangles whose normals differ by up to 14 degrees: a force along them would jump by 0.3 N.
  const double size = 0.05, radius = 0.0025, depth = 0.004, speed = 0.05;
  FeltBench bench(Rigid(), Ellipsoid(Vector3d::Constant(size), 2), Tool(radius));
  const auto at = [&](double angle, double height) {
    return FeltBench::At((size + radius + height) *
                         Vector3d(std::sin(angle), 0.1, std::cos(angle)).normalized());
  };
  for (double height = 0.003; height > -depth; height -= 5e-5) bench.SessionTick(at(-0.9, height));
  for (int i = 0; i < 100; ++i) bench.SessionTick(at(-0.9, -depth));
  Vector3d last = bench.Hand();
  double least = 10, most = 0, largest_change = 0;
  for (double angle = -0.9; angle < 0.9; angle += 1e-3 * speed / size) {
    bench.SessionTick(at(angle, -depth));
    least = std::min(least, bench.Hand().norm());
    most = std::max(most, bench.Hand().norm());
    largest_change = std::max(largest_change, (bench.Hand() - last).norm());
    last = bench.Hand();
  }
  // The facets lie up to 0.9 mm below the sphere.
  EXPECT_GT(least, kWall * (depth - 0.0011));
  EXPECT_LT(most, kWall * (depth + 1e-4));
  // In a tick the tip moves by 0.05 mm: along a facet that is tilted by up to 8 degrees the depth
  // changes by 0.007 mm, 0.002 N, and a force of 1.2 N turns with a normal that turns up to twice
  // as fast as the sphere's, by 0.002, 0.0024 N.
  EXPECT_LT(largest_change, 0.0045);
}

TEST(RigidOrgan, FrictionHoldsTheTipUntilItsConeEnds) {
  FeltBench bench(Rigid(), Ellipsoid(kRadii, 3), Tool());
  bench.friction = 0.5;
  ToolPose tool = Press(&bench, 0.0025, 0.005);
  for (int i = 0; i < 100; ++i) bench.SessionTick(tool);
  for (int i = 0; i < 20; ++i) {
    tool.X_WT.translation().x() += 5e-5;
    bench.SessionTick(tool);
  }
  // Sticking: the wall is a spring of the same stiffness sideways.
  EXPECT_NEAR(-bench.Hand().x(), kWall * 0.001, 1e-6);
  for (int i = 0; i < 200; ++i) {
    tool.X_WT.translation().x() += 5e-5;
    bench.SessionTick(tool);
  }
  const Vector3d n = bench.Felt().normal_W;
  const Vector3d along = bench.Hand() - n.dot(bench.Hand()) * n;
  EXPECT_NEAR(along.norm(), 0.5 * n.dot(bench.Hand()), 1e-6);  // slipping: on the cone
}

TEST(RigidOrgan, TipThatStartsInsideFeelsAFiniteForceOutwards) {
  for (const Vector3d& start :
       {Vector3d(0, 0, 0), Vector3d(0, 0, 0.03), Vector3d(0.05, 0.01, -0.02)}) {
    FeltBench bench(Rigid(), Ellipsoid(kRadii, 3), Tool());
    const ToolPose tool = FeltBench::At(start);
    for (int i = 0; i < 200; ++i) {
      bench.SessionTick(tool);
      ASSERT_TRUE(bench.Hand().allFinite()) << start.transpose();
      // Nowhere is the surface farther than the shortest half axis.
      ASSERT_LE(bench.Hand().norm(), kWall * (kRadii.minCoeff() + 0.0025) * 1.001);
    }
    EXPECT_GT(bench.Hand().norm(), 0);
  }
}

TEST(RigidOrgan, BreathingCarriesTheWall) {
  OrganOptions options = Rigid();
  options.motion.displacement_W = Vector3d(0, 0, 0.008);
  options.motion.frequency = 1;
  FeltBench bench(options, Ellipsoid(kRadii, 3), Tool());
  const double gap = 0.002;
  const ToolPose tool = FeltBench::At(Vector3d(0, 0, kRadii.z() + 0.0025 + gap));
  for (int tick = 1; tick <= 2000; ++tick) {
    bench.SessionTick(tool);
    const double rise = options.motion.Offset(tick * 1'000'000).z();
    // A patch's arrival is faded in from the force's extrapolated course, which misses a ramp that
    // bends by its second difference: 300 N/m 4 mm (2 pi / s)^2 ms^2, 5e-5 N.
    if (tick > 100) {
      ASSERT_NEAR(bench.Hand().z(), kWall * std::max(rise - gap, 0.0), 1e-4);
    }
  }
}

TEST(RigidOrgan, JawsThatCloseOnItPress) {
  ToolOptions grasper = Tool();
  grasper.geometries[0].can_grasp = true;
  FeltBench bench(Rigid(), Ellipsoid(kRadii, 3), grasper);
  const ToolPose open = Press(&bench, 0.0025, 0.005);
  ToolPose closed = open;
  closed.jaw = 0;
  for (int i = 0; i < 100; ++i) bench.SessionTick(closed);
  EXPECT_EQ(bench.Felt().kind, ContactKind::kPress);
  for (int i = 0; i < 200; ++i) {
    closed.X_WT.translation().z() += 1e-4;
    bench.SessionTick(closed);
  }
  EXPECT_EQ(bench.Hand(), Vector3d::Zero());  // nothing is held
}

TEST(RigidOrgan, SoftOrganBesideItIsAsItWouldBeAlone) {
  OrganOptions soft;
  soft.name = "soft";
  soft.energy.type = EnergyType::kStrain;
  soft.lattice.local.functions = 0;
  soft.supports.push_back({BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.25)}, {}});
  Isometry3d X_beside = Isometry3d::Identity();
  X_beside.translation().x() = 0.3;
  std::vector<OrganModel> alone, both;
  alone.emplace_back(soft, Ellipsoid(kRadii, 2));
  both.emplace_back(Rigid(), Ellipsoid(kRadii, 2, X_beside));
  both.emplace_back(soft, Ellipsoid(kRadii, 2));
  const auto run = [](const std::vector<OrganModel>& organs, ContactPatch* patch) {
    TripleBuffer<ToolState> tools;
    TripleBuffer<ContactPatch> patches;
    TripleBuffer<SceneSnapshot> render{SizedSnapshot(organs, 2, true)};
    TripleBuffer<SceneSnapshot> telemetry{SizedSnapshot(organs, 2, false)};
    DeformationLoop loop(organs, {Tool(), Tool()}, {tools, patches, render, telemetry});
    ToolState state;
    state.tool_count = 2;
    state.tools[0] = FeltBench::At(Vector3d(0.01, 0, kRadii.z() - 0.004));
    state.tools[1] = FeltBench::At(Vector3d(0.3, 0, kRadii.z() - 0.004));
    for (int i = 0; i < 3; ++i) loop.Step(state, i * 33'000'000);
    patches.Update();
    *patch = patches.Front();
    EXPECT_EQ(loop.record().flags, kStepOk);
    return loop.organ(static_cast<int>(organs.size()) - 1).vertices;
  };
  ContactPatch of_one, of_both;
  EXPECT_EQ(run(alone, &of_one), run(both, &of_both));
  EXPECT_EQ(of_both.tools[0].main().organ, 1);
  EXPECT_EQ(of_both.tools[1].main().organ, 0);
  EXPECT_EQ(of_both.tools[0].main().force_on_tissue_W, of_one.tools[0].main().force_on_tissue_W);
  // As deep as the tip's centre and its radius; the nearest point lies on a facet, 1 % less deep.
  EXPECT_NEAR(of_both.tools[1].main().force_on_tissue_W.z(), -kWall * (0.0025 + 0.004), 0.02);
}

}  // namespace
}  // namespace hpdm
