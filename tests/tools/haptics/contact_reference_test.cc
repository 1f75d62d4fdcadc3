#include "tools/haptics/contact_reference.h"

#include <gtest/gtest.h>

#include "tools/stress/motion_block.h"

namespace hpdm {
namespace {

// A block with a level top at z = 0 under one probe.
class BlockContact : public testing::Test {
 protected:
  BlockContact() {
    organs_.emplace_back(BlockOrgan(StressModel::kStrainSmall, true), BlockSurface(true));
  }
  static ToolState At(const Vector3d& p_tip_W) {
    ToolState state;
    state.tool_count = 1;
    state.tools[0].X_WT.translation() = p_tip_W;
    state.tools[0].p_trocar_W = p_tip_W + Vector3d(0, 0, 0.3);
    return state;
  }
  static std::vector<ToolOptions> Probe(double friction = 0) {
    return {{.geometries = {{.tip_radius = kRadius, .friction = friction}}}};
  }
  static constexpr double kRadius = 0.005;
  std::vector<OrganModel> organs_;
};

TEST_F(BlockContact, IsUnderTheTipInTheMiddleOfTheTop) {
  ContactReference reference(organs_, Probe(), 0.002);
  EXPECT_EQ(reference.Solve(At({0, 0, kRadius + 0.001}))[0].force_on_tissue_W.norm(), 0);
  for (const double depth : {0.001, 0.003, 0.006}) {
    const SolvedContact& contact = reference.Solve(At({0, 0, kRadius - depth}))[0];
    // The block is symmetric but for the diagonals of its mesh.
    EXPECT_NEAR(contact.contact_W.x(), 0, 0.02 * depth);
    EXPECT_NEAR(contact.contact_W.y(), 0, 0.02 * depth);
    EXPECT_NEAR(contact.contact_W.z(), -depth, 0.02 * depth);
    EXPECT_LT(contact.force_on_tissue_W.z(), -0.01);
    EXPECT_LT(contact.force_on_tissue_W.head<2>().norm(), 0.02 * contact.force_on_tissue_W.norm());
  }
  EXPECT_EQ(reference.unsolved(), 0);
}

TEST_F(BlockContact, DoesNotUseThePlaceOfTheTick) {
  ContactReference a(organs_, Probe(), 0.002), b(organs_, Probe(), 0.002);
  a.Solve(At({0.012, 0.007, kRadius + 0.001}));
  b.Solve(At({0.012, 0.007, kRadius + 0.001}));
  ToolState wrong = At({0.012, 0.007, kRadius - 0.004});
  const Vector3d force = a.Solve(wrong)[0].force_on_tissue_W;
  wrong.contact_points[0][0] = {.known_organ = 0,
                                .organ = 0,
                                .triangle = 5,
                                .weights = Vector3d(1, 0, 0),
                                .normal_W = Vector3d::UnitX()};
  EXPECT_EQ(b.Solve(wrong)[0].force_on_tissue_W, force);
  EXPECT_GT(force.norm(), 0.05);
}

// The pressed point lies under the tip wherever the tip is, at the edge too.
TEST_F(BlockContact, FulfilsItsConditionsOverTheWholeTop) {
  ContactReference reference(organs_, Probe(), 0.002);
  for (const double x : {-0.03, 0.011, 0.042}) {
    reference.Solve(At({x, 0.01, kRadius + 0.001}));
    const Vector3d p_tip_W(x, 0.01, kRadius - 0.003);
    const SolvedContact& contact = reference.Solve(At(p_tip_W))[0];
    const Vector3d off = p_tip_W - kRadius * contact.normal_W - contact.contact_W;
    EXPECT_LT(off.norm(), 2 * ContactReference::kUnder) << x;
  }
}

TEST_F(BlockContact, StaysWhereFrictionHoldsItAndSlipsOnTheCone) {
  constexpr double kFriction = 0.4;
  ContactReference reference(organs_, Probe(kFriction), 0.002);
  reference.Solve(At({0, 0, kRadius + 0.001}));
  reference.Solve(At({0, 0, kRadius - 0.004}));
  const auto share = [](const SolvedContact& contact) {
    const Vector3d& f = contact.force_on_tissue_W;
    const double pressing = -contact.normal_W.dot(f);
    return (f + pressing * contact.normal_W).norm() / pressing;
  };
  const double held = share(reference.Solve(At({3e-4, 0, kRadius - 0.004}))[0]);
  EXPECT_GT(held, 0.02);
  EXPECT_LT(held, kFriction);
  const double slips = share(reference.Solve(At({0.008, 0, kRadius - 0.004}))[0]);
  EXPECT_NEAR(slips, kFriction, 0.02);
}

}  // namespace
}  // namespace hpdm
