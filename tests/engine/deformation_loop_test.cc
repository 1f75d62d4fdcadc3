#include "engine/deformation_loop.h"

#include <gtest/gtest.h>

#include <limits>

#include "engine/base/error.h"
#include "tests/support/one_organ.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

// An ellipsoid of 0.1 x 0.07 x 0.05 m half-axes held in its lower part.
OrganOptions Options() {
  OrganOptions options;
  options.name = "ellipsoid";
  options.energy.type = EnergyType::kMetric;
  SupportOptions bottom;
  bottom.region = BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.25)};
  options.supports.push_back(bottom);
  return options;
}

class DeformationLoopTest : public testing::Test {
 protected:
  explicit DeformationLoopTest(const OrganOptions& options = Options())
      : models_(OneOrgan(options, Ellipsoid(Vector3d(0.1, 0.07, 0.05), 3))) {}

  // The shaft lies along z, the tip's centre at p.
  static ToolPose ToolAt(const Vector3d& p, double jaw = 1) {
    ToolPose tool;
    tool.X_WT.translation() = p;
    tool.p_trocar_W = p + Vector3d(0, 0, 0.2);
    tool.jaw = jaw;
    return tool;
  }
  void Step(const ToolPose& first, const ToolPose& second = ToolAt(Vector3d(1, 1, 1))) {
    ToolState tools;
    tools.tick = ++tick_;
    tools.tool_count = 2;
    tools.tools = {first, second};
    loop_->Step(tools, 0);
    patch_.Update();
    render_.Update();
  }
  void Start(const ToolOptions& tool = {}) {
    loop_ =
        std::make_unique<DeformationLoop>(models_, std::vector<ToolOptions>{tool, tool},
                                          DeformationEdges{tools_, patch_, render_, telemetry_});
  }
  double Gap(const Vector3d& p) const {  // of the deformed surface from the tip's surface
    const SurfaceTree tree(loop_->organ(0).vertices, models_[0].rest().triangles);
    return tree.Closest(p, 1).distance - ToolOptions().tip_radius;
  }

  std::vector<OrganModel> models_;
  TripleBuffer<ToolState> tools_;
  TripleBuffer<ContactPatch> patch_;
  TripleBuffer<SceneSnapshot> render_{SizedSnapshot(models_, 2, true)};
  TripleBuffer<SceneSnapshot> telemetry_{SizedSnapshot(models_, 2, false)};
  std::unique_ptr<DeformationLoop> loop_;
  std::uint64_t tick_ = 0;
};

TEST_F(DeformationLoopTest, FreeToolLeavesTheOrganAtRest) {
  Start();
  Step(ToolAt(Vector3d(0, 0, 0.08)));
  EXPECT_EQ(loop_->organ(0).vertices, models_[0].rest().vertices);
  EXPECT_EQ(patch_.Front().tools[0].force_on_tissue_W.norm(), 0);
  EXPECT_EQ(patch_.Front().tools[0].organ, 0);   // prefetched although not touching
  EXPECT_EQ(patch_.Front().tools[1].organ, -1);  // out of reach
}

TEST_F(DeformationLoopTest, StepBeforeTheFirstTickTouchesNothing) {
  Start();
  loop_->Step(loop_->NewestTools(), 0);  // nothing was published yet: tips at the origin, inside
  patch_.Update();
  EXPECT_EQ(loop_->organ(0).vertices, models_[0].rest().vertices);
  EXPECT_EQ(patch_.Front().tool_count, 0);
}

TEST_F(DeformationLoopTest, AnExchangedToolActsLikeOneThatWasThereFromTheStart) {
  const auto press = [this](int instrument_index) {
    for (double z = 0.06; z > 0.04; z -= 0.002) {
      ToolPose tool = ToolAt(Vector3d(0.02, 0.01, z));
      tool.instrument_index = instrument_index;
      Step(tool);
    }
    return loop_->organ(0).vertices;
  };
  const ToolGeometry thick{.tip_radius = 0.005, .shaft_radius = 0.004};
  Start({.tip_radius = thick.tip_radius, .shaft_radius = thick.shaft_radius});
  const Points expected = press(0);
  Start({.exchanges = {{}, thick}});
  EXPECT_EQ(press(2), expected);
  EXPECT_EQ(patch_.Front().tools[0].instrument_index, 2);
  EXPECT_EQ(patch_.Front().tools[0].kernel_radius, thick.tip_radius);
}

TEST_F(DeformationLoopTest, AnExchangeLetsGoOfWhatTheJawsHold) {
  Start({.can_grasp = true, .exchanges = {{.can_grasp = true}}});
  const Vector3d p(0, 0, 0.051);
  Step(ToolAt(p, 1));
  Step(ToolAt(p, 0));
  EXPECT_EQ(patch_.Front().tools[0].kind, ContactKind::kGrasp);
  ToolPose other = ToolAt(p, 0);
  other.instrument_index = 1;
  Step(other);
  EXPECT_NE(patch_.Front().tools[0].kind, ContactKind::kGrasp);
  Step(other);
  EXPECT_NE(patch_.Front().tools[0].kind, ContactKind::kGrasp) << "they were closed before";
}

TEST_F(DeformationLoopTest, PressedSurfaceFollowsTheTip) {
  Start();
  for (double z = 0.055; z > 0.035; z -= 0.001) Step(ToolAt(Vector3d(0.02, 0.01, z)));
  for (int i = 0; i < 10; ++i) Step(ToolAt(Vector3d(0.02, 0.01, 0.035)));
  // The contact is a point of a facet, so the sphere's sides may cut into it a little.
  EXPECT_NEAR(Gap(Vector3d(0.02, 0.01, 0.035)), 0, 5e-4);
  const ToolPatch& patch = patch_.Front().tools[0];
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
  EXPECT_EQ(patch_.Front().tools[0].force_on_tissue_W.norm(), 0);
}

TEST_F(DeformationLoopTest, PokeThatSkipsTheSurfaceInOneStepIsCaughtAtItsEntry) {
  Start();
  Step(ToolAt(Vector3d(0, 0, 0.07)));
  Step(ToolAt(Vector3d(0, 0, -0.03)));  // 20 mm from the far side, 80 mm from the near one
  const ToolPatch& patch = patch_.Front().tools[0];
  EXPECT_LT(patch.force_on_tissue_W.z(), 0);  // pushed on down, not out of the far side
  EXPECT_TRUE(loop_->organ(0).vertices.allFinite());
}

TEST_F(DeformationLoopTest, ShaftPushesTissueAside) {
  Start();
  ToolPose tool = ToolAt(Vector3d(0.05, 0, 0.1));
  // A shaft that lies across the top, 5 mm below it, with both ends outside.
  tool.X_WT.linear() = Eigen::AngleAxisd(-M_PI / 2, Vector3d::UnitY()).toRotationMatrix();
  tool.X_WT.translation() = Vector3d(0.15, 0, 0.045);
  tool.p_trocar_W = Vector3d(-0.15, 0, 0.045);
  for (int i = 0; i < 5; ++i) Step(tool);
  EXPECT_TRUE(patch_.Front().tools[0].shaft_contact);
  const SurfaceTree tree(loop_->organ(0).vertices, models_[0].rest().triangles);
  const SurfaceTree rest(models_[0].rest().vertices, models_[0].rest().triangles);
  const Vector3d below(0, 0, 0.03);
  EXPECT_LT(tree.Closest(below, 1).distance, rest.Closest(below, 1).distance - 0.002);
}

TEST_F(DeformationLoopTest, JawsCarryTheTissueAndLetItGo) {
  ToolOptions grasper;
  grasper.can_grasp = true;
  Start(grasper);
  const double top = 0.05 + grasper.tip_radius;
  Step(ToolAt(Vector3d(0, 0, top), 1));
  Step(ToolAt(Vector3d(0, 0, top), 0));
  Step(ToolAt(Vector3d(0.005, 0, top + 0.02), 0));
  const ToolPatch& held = patch_.Front().tools[0];
  EXPECT_EQ(held.kind, ContactKind::kGrasp);
  EXPECT_NEAR((held.contact_W - Vector3d(0.005, 0, 0.07)).norm(), 0, 1e-3);
  EXPECT_GT(held.force_on_tissue_W.z(), 0.1);
  Step(ToolAt(Vector3d(0.005, 0, top + 0.02), 1));
  EXPECT_EQ(patch_.Front().tools[0].kind, ContactKind::kPress);
  EXPECT_EQ(loop_->organ(0).vertices, models_[0].rest().vertices);
}

TEST_F(DeformationLoopTest, JawsThatCloseAboveTheSurfaceHoldAndLiftNothing) {
  const double top = 0.05 + ToolOptions().tip_radius;
  for (const double gap : {0.001, 0.002, 0.004}) {
    Start({.can_grasp = true});
    Step(ToolAt(Vector3d(0, 0, top + gap), 1));
    for (const double lift : {0.0, 0.01, 0.02}) {
      Step(ToolAt(Vector3d(0, 0, top + gap + lift), 0));
      EXPECT_EQ(patch_.Front().tools[0].kind, ContactKind::kPress) << gap;
      EXPECT_EQ(patch_.Front().tools[0].force_on_tissue_W, Vector3d::Zero()) << gap;
      EXPECT_EQ(loop_->organ(0).vertices, models_[0].rest().vertices) << gap;
    }
  }
}

// Jaws that come down on tissue which they closed above press it like any other tip.
TEST_F(DeformationLoopTest, JawsThatCameDownClosedHoldNothing) {
  const double top = 0.05 + ToolOptions().tip_radius;
  Start({.can_grasp = true});
  Step(ToolAt(Vector3d(0, 0, top + 0.004), 1));
  Step(ToolAt(Vector3d(0, 0, top + 0.004), 0));
  Step(ToolAt(Vector3d(0, 0, top - 0.005), 0));
  EXPECT_LT(patch_.Front().tools[0].force_on_tissue_W.z(), -0.1);
  Step(ToolAt(Vector3d(0, 0, top + 0.02), 0));
  EXPECT_EQ(loop_->organ(0).vertices, models_[0].rest().vertices);
}

// A shaft along the ellipsoid's end: the tissue lies between the middles of the jaws, and their tip
// is free.
TEST_F(DeformationLoopTest, JawsHoldTissueThatTheirTipIsPast) {
  const double radius = ToolOptions().tip_radius;
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
    Start({.can_grasp = true});
    Step(ToolAt(p, 1));
    Step(ToolAt(p, 0));
    const Vector3d held = patch_.Front().tools[0].contact_W;
    Step(ToolAt(p + Vector3d(0.01, 0, 0), 0));
    const ToolPatch& patch = patch_.Front().tools[0];
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

TEST_F(DeformationLoopTest, ProbeCannotGrasp) {
  Start();
  Step(ToolAt(Vector3d(0, 0, 0.0525), 1));
  Step(ToolAt(Vector3d(0, 0, 0.0525), 0));
  Step(ToolAt(Vector3d(0, 0, 0.08), 0));
  EXPECT_EQ(loop_->organ(0).vertices, models_[0].rest().vertices);
}

TEST_F(DeformationLoopTest, PatchIsBoundedAndConsistent) {
  ToolOptions paper;
  paper.reaction = ReactionType::kPaper;
  Start(paper);
  Step(ToolAt(Vector3d(0.02, 0.01, 0.05)));
  const ToolPatch& patch = patch_.Front().tools[0];
  EXPECT_GT(patch.triangle_count, 10);
  EXPECT_LE(patch.triangle_count, ToolPatch::kMaxTriangles);
  EXPECT_LE(patch.point_count, ToolPatch::kMaxPoints);
  for (int t = 0; t < patch.triangle_count; ++t) {
    for (int corner : patch.triangles[t]) ASSERT_LT(corner, patch.point_count);
  }
  for (int p = 0; p < patch.point_count; ++p) {
    const PatchPoint& point = patch.points[p];
    EXPECT_GE(point.node.neighbour_count, 5);
    for (int i = 0; i < point.node.neighbour_count; ++i) {
      EXPECT_DOUBLE_EQ(point.node.neighbours[i].edge.norm(), point.node.neighbours[i].rest_length);
    }
  }
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
  grasper.can_grasp = true;
  Start(grasper);
  const double top = 0.05 + grasper.tip_radius;
  Step(ToolAt(Vector3d(-0.001, 0, top)), ToolAt(Vector3d(0.001, 0, top)));
  Step(ToolAt(Vector3d(-0.001, 0, top), 0), ToolAt(Vector3d(0.001, 0, top), 0));
  Step(ToolAt(Vector3d(-0.05, 0, top + 0.05), 0), ToolAt(Vector3d(0.05, 0, top + 0.05), 0));
  EXPECT_TRUE(loop_->organ(0).vertices.allFinite());
  EXPECT_EQ(loop_->record().flags & kStepNotFinite, 0u);
  Step(ToolAt(Vector3d(-0.05, 0, 0.2), 1), ToolAt(Vector3d(0.05, 0, 0.2), 1));
  EXPECT_EQ(loop_->organ(0).vertices, models_[0].rest().vertices);
}

TEST_F(DeformationLoopTest, APoseThatIsNotFiniteCountsAsTheLastThatWas) {
  const double top = 0.05 + ToolOptions().tip_radius;
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  ToolOptions grasper;
  grasper.can_grasp = true;
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
    OrganOptions options = Options();
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
    OrganOptions options = Options();
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

TEST(OrganModel, SupportOutsideTheTissueIsRefused) {
  OrganOptions options = Options();
  options.supports[0].region = Sphere{Vector3d(1, 1, 1), 0.01};
  EXPECT_THROW(OrganModel(options, Ellipsoid(Vector3d(0.1, 0.07, 0.05), 2)), InputError);
}

}  // namespace
}  // namespace hpdm
