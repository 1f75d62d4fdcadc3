#include "tools/session/scene_defaults.h"

#include <gtest/gtest.h>

#include "engine/tissue/support.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

const Vector3d kBodyRadii(0.1, 0.08, 0.06);  // m

Scene WithTrocars(const std::vector<Vector3d>& trocars) {
  Scene scene;
  for (const Vector3d& trocar : trocars) scene.instruments.emplace_back().p_trocar_W = trocar;
  return scene;
}

/// Returns what is held of an ellipsoid with its centre at the origin, m.
Box Held(const Scene& scene) {
  OrganOptions organ;
  organ.name = "liver";
  const SurfaceMesh rest = Ellipsoid(kBodyRadii, 2);
  EXPECT_NE(HoldRear(scene, rest, &organ), "");
  if (organ.supports.size() != 1) throw std::runtime_error("not one support");
  EXPECT_FALSE(organ.supports[0].stiffness) << "fixed";
  return BoundsOf(organ.supports[0].region, AxisAlignedBounds(rest.vertices));
}

TEST(HoldRear, HoldsTheSideAwayFromTheTrocars) {
  // 30 % of 0.16 m or 0.2 m.
  EXPECT_NEAR(Held(WithTrocars({{0.05, -0.12, 0.16}})).min.y(), 0.08 - 0.048, 1e-3);
  EXPECT_NEAR(Held(WithTrocars({{0.05, 0.12, 0.16}})).max.y(), -0.08 + 0.048, 1e-3);
  EXPECT_NEAR(Held(WithTrocars({{0.2, -0.12, 0.16}})).max.x(), -0.1 + 0.06, 1e-3);
  EXPECT_NEAR(Held(WithTrocars({{-0.2, -0.12, 0.16}})).min.x(), 0.1 - 0.06, 1e-3);
}

TEST(HoldRear, TwoHandsFromLeftAndRightCountByTheirMean) {
  const Box held = Held(WithTrocars({{0.2, -0.12, 0.16}, {-0.2, -0.12, 0.16}}));
  EXPECT_NEAR(held.min.y(), 0.08 - 0.048, 1e-3);
  EXPECT_LT(held.min.x(), -0.09) << "its whole width";
}

TEST(HoldRear, LeavesSupportsRigidOrgansAndLoadCasesAlone) {
  const SurfaceMesh rest = Ellipsoid(kBodyRadii, 2);
  const Scene scene = WithTrocars({{0, -0.1, 0.2}});
  OrganOptions supported, rigid, load_case;
  supported.supports = {{Sphere{Vector3d::Zero(), 0.05}, 1e6}};
  rigid.model = OrganModelType::kRigid;
  EXPECT_EQ(HoldRear(scene, rest, &supported), "");
  EXPECT_EQ(supported.supports.size(), 1u);
  EXPECT_EQ(HoldRear(scene, rest, &rigid), "");
  EXPECT_TRUE(rigid.supports.empty());
  EXPECT_EQ(HoldRear(Scene(), rest, &load_case), "");
  EXPECT_TRUE(load_case.supports.empty());
}

TEST(LookAtOrgans, OnlyTheDefaultViewFollowsTheOrgans) {
  const Box far{Vector3d(4.9, 4.9, 0.9), Vector3d(5.1, 5.1, 1.1)};
  LaparoscopeOptions scope;
  const Vector3d view = scope.p_target_W - scope.p_scope_W;
  LookAtOrgans(far, &scope);
  EXPECT_LT((scope.p_target_W - Vector3d(5, 5, 1)).norm(), 1e-12);
  EXPECT_LT((scope.p_target_W - scope.p_scope_W - view).norm(), 1e-12) << "from the same side";
  LaparoscopeOptions chosen;
  chosen.p_target_W.x() = 0.01;
  LookAtOrgans(far, &chosen);
  EXPECT_EQ(chosen.p_target_W, Vector3d(0.01, 0, 0));
  EXPECT_EQ(chosen.p_scope_W, LaparoscopeOptions().p_scope_W);
}

}  // namespace
}  // namespace hpdm
