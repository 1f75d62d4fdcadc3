#include "engine/deformation_loop.h"

#include <limits>

#include "tests/support/deformation_loop_fixture.h"

namespace hpdm {
namespace {

TEST_F(DeformationLoopTest, FreeToolLeavesTheOrganAtRest) {
  Start();
  Step(ToolAt(Vector3d(0, 0, 0.08)));
  EXPECT_EQ(loop_->organ(0).vertices, models_[0].rest().vertices);
  EXPECT_EQ(patch_.Front().tools[0].main().force_on_tissue_W.norm(), 0);
  EXPECT_EQ(patch_.Front().tools[0].main().organ, 0);   // prefetched although not touching
  EXPECT_EQ(patch_.Front().tools[1].main().organ, -1);  // out of reach
}

TEST_F(DeformationLoopTest, StepBeforeTheFirstTickTouchesNothing) {
  Start();
  loop_->Step(loop_->NewestTools(), 0);  // nothing was published yet: tips at the origin, inside
  patch_.Update();
  EXPECT_EQ(loop_->organ(0).vertices, models_[0].rest().vertices);
  EXPECT_EQ(patch_.Front().tool_count, 0);
}

TEST_F(DeformationLoopTest, PressedSurfaceFollowsTheTip) {
  Start();
  for (double z = 0.055; z > 0.035; z -= 0.001) Step(ToolAt(Vector3d(0.02, 0.01, z)));
  for (int i = 0; i < 10; ++i) Step(ToolAt(Vector3d(0.02, 0.01, 0.035)));
  // The contact is a point of a facet, so the sphere's sides may cut into it a little.
  EXPECT_NEAR(Gap(Vector3d(0.02, 0.01, 0.035)), 0, 5e-4);
  const ToolPatch& patch = patch_.Front().tools[0].main();
  EXPECT_LT(patch.force_on_tissue_W.z(), -0.1);
  EXPECT_NEAR((patch.contact_W - Vector3d(0.02, 0.01, 0.0325)).norm(), 0, 1e-3);
}

TEST_F(DeformationLoopTest, ReleasedOrganReturnsToRest) {
  Start();
  Step(ToolAt(Vector3d(0, 0, 0.055)));
  Step(ToolAt(Vector3d(0, 0, 0.03)));
  EXPECT_GT((loop_->organ(0).vertices - models_[0].rest().vertices).norm(), 0.01);
  Step(ToolAt(Vector3d(0, 0, 0.07)));
  EXPECT_EQ(loop_->organ(0).vertices, models_[0].rest().vertices);
  EXPECT_EQ(patch_.Front().tools[0].main().force_on_tissue_W.norm(), 0);
}

TEST_F(DeformationLoopTest, SnapshotsCarryTheStepTheyBelongTo) {
  Start();
  for (int i = 1; i <= 3; ++i) {
    Step(ToolAt(Vector3d(0, 0, 0.05 - 0.002 * i)));
    EXPECT_EQ(patch_.Front().step.number, static_cast<std::uint64_t>(i));
    EXPECT_EQ(patch_.Front().step.input_tick, static_cast<std::uint64_t>(i));
    EXPECT_EQ(render_.Front().step.number, static_cast<std::uint64_t>(i));
    EXPECT_EQ(render_.Front().organs[0].vertices, loop_->organ(0).vertices.cast<float>());
  }
}

TEST_F(DeformationLoopTest, TwoToolsPullingAgainstEachOtherStayFinite) {
  ToolOptions grasper;
  grasper.geometries[0].can_grasp = true;
  Start(grasper);
  const double top = 0.05 + grasper.geometries[0].tip_radius;
  Step(ToolAt(Vector3d(-0.001, 0, top)), ToolAt(Vector3d(0.001, 0, top)));
  Step(ToolAt(Vector3d(-0.001, 0, top), 0), ToolAt(Vector3d(0.001, 0, top), 0));
  Step(ToolAt(Vector3d(-0.05, 0, top + 0.05), 0), ToolAt(Vector3d(0.05, 0, top + 0.05), 0));
  EXPECT_TRUE(loop_->organ(0).vertices.allFinite());
  EXPECT_EQ(loop_->record().flags & kStepNotFinite, 0u);
  Step(ToolAt(Vector3d(-0.05, 0, 0.2), 1), ToolAt(Vector3d(0.05, 0, 0.2), 1));
  EXPECT_EQ(loop_->organ(0).vertices, models_[0].rest().vertices);
}

TEST_F(DeformationLoopTest, APoseThatIsNotFiniteCountsAsTheLastThatWas) {
  const double top = 0.05 + kDefaultToolRadius;
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  ToolOptions grasper;
  grasper.geometries[0].can_grasp = true;
  Start(grasper);
  ToolPose nowhere = ToolAt(Vector3d::Constant(kNan));
  Step(nowhere);  // before it ever had a pose
  EXPECT_NE(loop_->record().flags & kStepNotFinite, 0u);
  EXPECT_EQ(loop_->organ(0).vertices, models_[0].rest().vertices);
  const ToolPose pressing = ToolAt(Vector3d(0, 0, top - 0.01));
  Step(pressing);
  nowhere.jaw = 0;  // nor do its jaws close on anything
  for (int i = 0; i < 3; ++i) {
    Step(nowhere);
    EXPECT_NE(loop_->record().flags & kStepNotFinite, 0u);
  }
  const Points held = loop_->organ(0).vertices;
  Start(grasper);
  Step(ToolAt(Vector3d(1, 1, 1)));
  for (int i = 0; i < 4; ++i) Step(pressing);
  EXPECT_NE(held, models_[0].rest().vertices);
  // The point under the tip was found from another side, and settles over the steps.
  EXPECT_LT((held - loop_->organ(0).vertices).cwiseAbs().maxCoeff(), 1e-5);
  Step(ToolAt(Vector3d(0, 0, 0.08)));
  EXPECT_EQ(loop_->record().flags, 0u);
  EXPECT_EQ(loop_->organ(0).vertices, models_[0].rest().vertices);
}

class GaussSeidelLoopTest : public DeformationLoopTest {
 protected:
  static OrganOptions WithGaussSeidel() {
    OrganOptions options = PressedEllipsoidOptions();
    options.energy.solver = SolverType::kGaussSeidel;
    return options;
  }
  GaussSeidelLoopTest() : DeformationLoopTest(WithGaussSeidel()) {}
};

TEST_F(GaussSeidelLoopTest, ConvergesWithinItsBudgetOnAPress) {
  Start();
  for (double z = 0.055; z > 0.035; z -= 0.002) Step(ToolAt(Vector3d(0.02, 0.01, z)));
  EXPECT_EQ(loop_->record().flags & kStepBudgetSpent, 0u) << loop_->record().residual;
  EXPECT_GT(loop_->record().iterations, 1);
}

class BareOrganTest : public DeformationLoopTest {
 protected:
  static OrganOptions WithoutSupport() {
    OrganOptions options = PressedEllipsoidOptions();
    options.supports.clear();
    return options;
  }
  BareOrganTest() : DeformationLoopTest(WithoutSupport()) {}
};

TEST_F(BareOrganTest, StaysFiniteAndWarns) {
  ASSERT_EQ(models_[0].warnings().size(), 1u);
  EXPECT_NE(models_[0].warnings()[0].find("support"), std::string::npos);
  Start();
  Step(ToolAt(Vector3d(0, 0, 0.055)));
  Step(ToolAt(Vector3d(0, 0, 0.03)));
  EXPECT_TRUE(loop_->organ(0).vertices.allFinite());
  EXPECT_LT(loop_->organ(0).control_displacements.rowwise().norm().maxCoeff(), 0.2);
}

}  // namespace
}  // namespace hpdm
