// Tissue in the jaws under a pull along their faces, and under a rotation of the jaws.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/felt_bench.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

constexpr double kClosingForce = 0.25, kJawFriction = 0.5;
constexpr double kHold = 2 * kClosingForce * kJawFriction;

class SlipTest : public testing::Test {
 protected:
  static OrganOptions Options() {
    OrganOptions options;
    options.name = "ellipsoid";
    options.supports.push_back({BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.25)}, {}});
    return options;
  }
  static ToolOptions Grasper(double closing_force) {
    ToolOptions tool;
    tool.geometries[0].can_grasp = true;
    tool.geometries[0].closing_force = closing_force;
    tool.geometries[0].jaw_friction = kJawFriction;
    return tool;
  }
  // Closes the jaws on the ellipsoid below (x, y).
  explicit SlipTest(double closing_force = kClosingForce, double x = 0, double y = 0)
      : bench_(Options(), Ellipsoid(Vector3d(0.1, 0.07, 0.05), 3), Grasper(closing_force)),
        p_(bench_.Top(x, y) + Vector3d(0, 0, kDefaultToolRadius - 0.001)) {
    Stay(100, 1);
    Stay(100, 0);
  }
  void Stay(int ticks, double jaw) {
    for (int i = 0; i < ticks; ++i) bench_.SessionTick(FeltBench::At(p_, jaw));
  }
  // Moves the jaws at 20 mm/s; returns the largest force along the faces.
  double Pull(const Vector3d& way, int ticks) {
    double largest = 0;
    for (int i = 0; i < ticks; ++i) {
      p_ += way / ticks;
      bench_.SessionTick(FeltBench::At(p_, 0));
      largest = std::max(largest, std::hypot(bench_.Hand().y(), bench_.Hand().z()));
    }
    return largest;
  }

  FeltBench bench_;
  Vector3d p_;
};

class HoldTest : public SlipTest {
 protected:
  HoldTest() : SlipTest(100, 0.07, 0.03) {}
};

TEST_F(SlipTest, APullWithinTheHoldDoesNotSlip) {
  ASSERT_EQ(bench_.Felt().kind, ContactKind::kGrasp);
  EXPECT_LT(Pull(Vector3d(0, 0, 0.001), 50), kHold);
  EXPECT_EQ(bench_.Felt().slip, 0);
}

TEST_F(SlipTest, APullBeyondTheHoldSlipsAtTheLimitAndEndsTheGrasp) {
  // The hand-over between patches adds less than 5 %.
  EXPECT_LT(Pull(Vector3d(0, 0, 0.008), 400), 1.05 * kHold);
  EXPECT_EQ(bench_.Felt().kind, ContactKind::kGrasp);
  const double slip = bench_.Felt().slip;
  EXPECT_GT(slip, 0.001);
  Stay(200, 0);
  EXPECT_NEAR(bench_.Hand().z(), -kHold, 0.02 * kHold) << "a hand at rest keeps the limit";
  EXPECT_NEAR(bench_.Patch().force_on_tissue_W.z(), kHold, 0.02 * kHold) << "so does the step";
  EXPECT_LT(Pull(Vector3d(0, 0, 0.02), 1000), 1.05 * kHold);
  Stay(100, 0);
  EXPECT_NE(bench_.Felt().kind, ContactKind::kGrasp) << "the tissue has left the faces";
}

TEST_F(SlipTest, TheHandsWorkIsStoredOrLostToFriction) {
  const auto stored = [this] {  // beyond that at release, J
    const Vector3d force = bench_.Hand();
    return 0.5 * force.dot(bench_.Patch().compliance_W * force);
  };
  const double at_start = stored();
  double work = 0;
  for (const double way : {0.008, -0.008}) {
    for (int i = 0; i < 800; ++i) {
      p_.z() += way / 800;
      bench_.SessionTick(FeltBench::At(p_, 0));
      work -= bench_.Hand().z() * way / 800;
    }
  }
  const double slip = bench_.Felt().slip;
  ASSERT_GT(slip, 0.002);
  EXPECT_NEAR(work, kHold * slip + stored() - at_start, 0.02 * work);
}

// Contacts beside it, such as a shaft's, are solved in rounds. The first ones may have other forces.
TEST_F(SlipTest, OnlyTheLastRoundOfATickSlips) {
  HapticContact jaws;
  jaws.SetPatch(bench_.Patch());
  TipPose tip;
  tip.X_WT = FeltBench::At(p_, 0).X_WT;
  tip.jaw = 0;
  jaws.Locate(tip);
  jaws.PushTo(Vector3d(0, 0, -0.01));
  jaws.FindForce();
  EXPECT_NEAR(jaws.found_W().z(), kHold, 0.01 * kHold) << "it would slip";
  jaws.PushTo(Vector3d::Zero());
  jaws.FindForce();
  jaws.Apply();
  EXPECT_EQ(jaws.result().slip, 0);
  EXPECT_LT((jaws.found_W() - bench_.Patch().force_on_tissue_W).norm(), 1e-9);
}

// The step moves every tie; the tick knows the jaws' rotation only by TipCompliance::Tip::turn_W.
TEST_F(HoldTest, ATickTurnsTheTissueWithTheJaws) {
  Pull(Vector3d(0.004, 0.002, 0.006), 300);
  Stay(200, 0);
  for (const Vector3d& axis : {Vector3d(1, 0, 0), Vector3d(0, 1, 0)}) {
    ToolPose turned = FeltBench::At(p_, 0);
    turned.X_WT.linear() = Eigen::AngleAxisd(0.02, axis).toRotationMatrix();
    const Vector3d before = bench_.Patch().force_on_tissue_W;
    bench_.Settle(turned);
    const Vector3d felt = bench_.Hand();
    bench_.Step(turned);
    const Vector3d change = bench_.Patch().force_on_tissue_W - before;
    EXPECT_LT((felt + before + change).norm(), 0.005 * change.norm()) << axis.transpose();
    EXPECT_GT(change.norm(), 5e-4) << axis.transpose();
    bench_.Step(FeltBench::At(p_, 0));
    bench_.Settle(FeltBench::At(p_, 0));
  }
}

}  // namespace
}  // namespace hpdm
