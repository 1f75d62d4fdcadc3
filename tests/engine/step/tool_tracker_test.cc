#include "engine/step/tool_tracker.h"

#include <cmath>

#include "tests/support/deformation_loop_fixture.h"

namespace hpdm {
namespace {

using ToolTrackerTest = DeformationLoopTest;

TEST_F(ToolTrackerTest, AnExchangedToolActsLikeOneThatWasThereFromTheStart) {
  const auto press = [this](int instrument_index) {
    for (double z = 0.06; z > 0.04; z -= 0.002) {
      ToolPose tool = ToolAt(Vector3d(0.02, 0.01, z));
      tool.instrument_index = instrument_index;
      Step(tool);
    }
    return loop_->organ(0).vertices;
  };
  const ToolGeometry thick{.tip_radius = 0.005, .shaft_radius = 0.004};
  Start({.geometries = {thick}});
  const Points expected = press(0);
  Start({.geometries = {{}, {}, thick}});
  EXPECT_EQ(press(2), expected);
  EXPECT_EQ(patch_.Front().tools[0].instrument_index, 2);
  EXPECT_EQ(patch_.Front().tools[0].main().kernel_radius, thick.tip_radius);
}

TEST_F(ToolTrackerTest, AnExchangeLetsGoOfWhatTheJawsHold) {
  Start({.geometries = {{.can_grasp = true}, {.can_grasp = true}}});
  const Vector3d p(0, 0, 0.051);
  Step(ToolAt(p, 1));
  Step(ToolAt(p, 0));
  EXPECT_EQ(patch_.Front().tools[0].main().kind, ContactKind::kGrasp);
  ToolPose other = ToolAt(p, 0);
  other.instrument_index = 1;
  Step(other);
  EXPECT_NE(patch_.Front().tools[0].main().kind, ContactKind::kGrasp);
  Step(other);
  EXPECT_NE(patch_.Front().tools[0].main().kind, ContactKind::kGrasp) << "they were closed before";
}

TEST_F(ToolTrackerTest, PokeThatSkipsTheSurfaceInOneStepIsCaughtAtItsEntry) {
  Start();
  Step(ToolAt(Vector3d(0, 0, 0.07)));
  Step(ToolAt(Vector3d(0, 0, -0.03)));  // 20 mm from the far side, 80 mm from the near one
  const ToolPatch& patch = patch_.Front().tools[0].main();
  EXPECT_LT(patch.force_on_tissue_W.z(), 0);  // pushed on down, not out of the far side
  EXPECT_TRUE(loop_->organ(0).vertices.allFinite());
}

TEST_F(ToolTrackerTest, ShaftPushesTissueAside) {
  Start();
  ToolPose tool = ToolAt(Vector3d(0.05, 0, 0.1));
  // A shaft that lies across the top, 5 mm below it, with both ends outside.
  tool.X_WT.linear() = Eigen::AngleAxisd(-M_PI / 2, Vector3d::UnitY()).toRotationMatrix();
  tool.X_WT.translation() = Vector3d(0.15, 0, 0.045);
  tool.p_trocar_W = Vector3d(-0.15, 0, 0.045);
  for (int i = 0; i < 5; ++i) Step(tool);
  EXPECT_TRUE(patch_.Front().tools[0].main().shaft_contact);
  const SurfaceTree tree(loop_->organ(0).vertices, models_[0].rest().triangles);
  const SurfaceTree rest(models_[0].rest().vertices, models_[0].rest().triangles);
  const Vector3d below(0, 0, 0.03);
  EXPECT_LT(tree.Closest(below, 1).distance, rest.Closest(below, 1).distance - 0.002);
}

TEST_F(ToolTrackerTest, JawsCarryTheTissueAndLetItGo) {
  ToolOptions grasper;
  grasper.geometries[0].can_grasp = true;
  Start(grasper);
  const double top = 0.05 + grasper.geometries[0].tip_radius;
  Step(ToolAt(Vector3d(0, 0, top), 1));
  Step(ToolAt(Vector3d(0, 0, top), 0));
  Step(ToolAt(Vector3d(0.005, 0, top + 0.02), 0));
  const ToolPatch& held = patch_.Front().tools[0].main();
  EXPECT_EQ(held.kind, ContactKind::kGrasp);
  EXPECT_NEAR((held.contact_W - Vector3d(0.005, 0, 0.07)).norm(), 0, 1e-3);
  EXPECT_GT(held.force_on_tissue_W.z(), 0.1);
  Step(ToolAt(Vector3d(0.005, 0, top + 0.02), 1));
  EXPECT_EQ(patch_.Front().tools[0].main().kind, ContactKind::kPress);
  EXPECT_EQ(loop_->organ(0).vertices, models_[0].rest().vertices);
}

TEST_F(ToolTrackerTest, JawsThatCloseAboveTheSurfaceHoldAndLiftNothing) {
  const double top = 0.05 + kDefaultToolRadius;
  for (const double gap : {0.001, 0.002, 0.004}) {
    Start({.geometries = {{.can_grasp = true}}});
    Step(ToolAt(Vector3d(0, 0, top + gap), 1));
    for (const double lift : {0.0, 0.01, 0.02}) {
      Step(ToolAt(Vector3d(0, 0, top + gap + lift), 0));
      EXPECT_EQ(patch_.Front().tools[0].main().kind, ContactKind::kPress) << gap;
      EXPECT_EQ(patch_.Front().tools[0].main().force_on_tissue_W, Vector3d::Zero()) << gap;
      EXPECT_EQ(loop_->organ(0).vertices, models_[0].rest().vertices) << gap;
    }
  }
}

// Jaws that come down on tissue which they closed above press it like any other tip.
TEST_F(ToolTrackerTest, JawsThatCameDownClosedHoldNothing) {
  const double top = 0.05 + kDefaultToolRadius;
  Start({.geometries = {{.can_grasp = true}}});
  Step(ToolAt(Vector3d(0, 0, top + 0.004), 1));
  Step(ToolAt(Vector3d(0, 0, top + 0.004), 0));
  Step(ToolAt(Vector3d(0, 0, top - 0.005), 0));
  EXPECT_LT(patch_.Front().tools[0].main().force_on_tissue_W.z(), -0.1);
  Step(ToolAt(Vector3d(0, 0, top + 0.02), 0));
  EXPECT_EQ(loop_->organ(0).vertices, models_[0].rest().vertices);
}

// A shaft along the ellipsoid's end: the tissue lies between the middles of the jaws, and their tip
// is free.
TEST_F(ToolTrackerTest, JawsHoldTissueThatTheirTipIsPast) {
  const double radius = kDefaultToolRadius;
  const SurfaceTree rest(models_[0].rest().vertices, models_[0].rest().triangles);
  const auto beside = [&](double distance) {  // of the jaws' axis from the surface
    Vector3d p(0.12, 0, -0.008);
    for (int i = 0; i < 20; ++i) {
      const Vector3d end = p + Vector3d(0, 0, 4 * radius);
      p.x() += distance - rest.ClosestToSegment(p, end, 1).distance;
    }
    return p;
  };
  for (const double gap : {0.001, 0.0}) {
    const Vector3d p = beside(radius + gap);
    ASSERT_GT(rest.Closest(p, 1).distance, radius + 0.0006) << "the tip is free";
    Start({.geometries = {{.can_grasp = true}}});
    Step(ToolAt(p, 1));
    Step(ToolAt(p, 0));
    const Vector3d held = patch_.Front().tools[0].main().contact_W;
    Step(ToolAt(p + Vector3d(0.01, 0, 0), 0));
    const ToolPatch& patch = patch_.Front().tools[0].main();
    if (gap > 0) {
      EXPECT_EQ(patch.kind, ContactKind::kPress);
      EXPECT_EQ(loop_->organ(0).vertices, models_[0].rest().vertices);
      continue;
    }
    EXPECT_EQ(patch.kind, ContactKind::kGrasp);
    EXPECT_GT(held.z(), p.z() + radius) << "behind the tip";
    // Held tissue moves with the jaws, up to the 1e-6 that regularised contacts may lack.
    EXPECT_LT((patch.contact_W - held - Vector3d(0.01, 0, 0)).norm(), 1e-5);
    EXPECT_GT(patch.force_on_tissue_W.x(), 0.1);
  }
}

TEST_F(ToolTrackerTest, ProbeCannotGrasp) {
  Start();
  Step(ToolAt(Vector3d(0, 0, 0.0525), 1));
  Step(ToolAt(Vector3d(0, 0, 0.0525), 0));
  Step(ToolAt(Vector3d(0, 0, 0.08), 0));
  EXPECT_EQ(loop_->organ(0).vertices, models_[0].rest().vertices);
}

}  // namespace
}  // namespace hpdm
