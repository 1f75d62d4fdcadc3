#include "haptics/contact/haptic_contact.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "haptics/contact/reaction_force.h"
#include "haptics/device/hand_script.h"
#include "tests/support/contact_patches.h"

namespace hpdm {
namespace {

constexpr double kRadius = 0.0025;  // m, of the tip
constexpr double kStiffness = 120;  // N/m

TipPose At(const Vector3d& p_tip_W, double radius = kRadius) {
  return {.X_WT = Isometry3d(Eigen::Translation3d(p_tip_W)), .tip_radius = radius};
}

HapticForce Press(ToolPatch patch, const Vector3d& p_tip_W, double radius = kRadius) {
  patch.Pack();
  HapticContact contact;
  contact.SetPatch(patch);
  return contact.Evaluate(At(p_tip_W, radius));
}

TEST(HapticContact, APressIntoAPlaneHasTheDepthAndForceOfItsSpring) {
  const ToolPatch patch = PlanePatch(7, 0.03, kStiffness);
  const HapticForce above = Press(patch, {0.001, 0.002, 1.001 * kRadius});
  EXPECT_EQ(above.kind, ContactKind::kNone);
  EXPECT_EQ(above.organ, -1);
  EXPECT_EQ(above.reaction_W, Vector3d::Zero());

  for (const double z : {0.002, 0.0, -0.004}) {  // centre above, on and below the surface
    const HapticForce press = Press(patch, {0.001, 0.002, z});
    EXPECT_EQ(press.kind, ContactKind::kPress);
    EXPECT_EQ(press.organ, 0);
    EXPECT_NEAR(press.depth, kRadius - z, 1e-15);
    EXPECT_LT((press.reaction_W - Vector3d(0, 0, kStiffness * (kRadius - z))).norm(), 1e-12);
  }
}

// Slides in steps of 1 um over many edges, with the tip's centre above and far below the surface.
// On the sphere the closest point itself would jump by more than a millimetre.
TEST(HapticContact, ForceIsContinuousWhileSliding) {
  const double R = 0.05;
  for (const bool sphere : {false, true}) {
    ToolPatch patch =
        sphere ? SpherePatch(7, 0.03, R, kStiffness) : PlanePatch(7, 0.03, kStiffness);
    HandRandom random(5);
    const double kHigh = 1.5 * kStiffness;
    for (int i = 0; i < patch.point_count; ++i) {
      patch.nodes[i].k1 = random.Uniform(kStiffness, kHigh);
    }
    HapticContact contact;
    contact.SetPatch(patch);
    for (const double depth : {0.001, 0.004, 0.012}) {
      Vector3d last = Vector3d::Zero();
      double steepest = 0;
      for (int step = 0; step <= 40'000; ++step) {
        const double x = -0.02 + step * 1e-6;
        Vector3d p(x, 0.37 * x + 0.001, 0);
        if (sphere) {
          const Vector3d direction = (p + Vector3d(0, 0, R)).normalized();
          p = Vector3d(0, 0, -R) + (R + kRadius - depth) * direction;
        } else {
          p.z() = kRadius - depth;
        }
        const HapticForce result = contact.Evaluate(At(p));
        ASSERT_EQ(result.kind, ContactKind::kPress);
        if (step > 0) {
          steepest = std::max(steepest, (result.reaction_W - last).norm() / 1e-6);
        }
        last = result.reaction_W;
      }
      // Bound of dF/ds, N/m: the stiffness changes by 60 N/m over an edge's height of 7 mm; the
      // sphere's facets slope by edge / 2R = 0.14 and its normal turns by 1/R. 1.5: interpolation,
      // and paths that are up to 1.07 longer than x. One jump of 1 % of the force would show as
      // 1e4 N/m.
      const double bound = 1.5 * (depth * (kHigh - kStiffness) / 0.007 +
                                  (sphere ? kHigh * (0.14 + 1.5 * depth / R) : 0));
      EXPECT_LT(steepest, bound) << (sphere ? "sphere" : "plane") << ", depth " << depth;
    }
  }
}

TEST(HapticContact, ForceGrowsContinuouslyFromZeroOnContact) {
  const ToolPatch patch = SpherePatch(7, 0.03, 0.05, kStiffness);
  double last = 0;
  for (double z = 0.004; z > -0.01; z -= 1e-6) {
    const double force = Press(patch, {0.0031, 0.0017, z}).reaction_W.norm();
    // k times 1 um, 1 % for the tilt of the normal.
    EXPECT_LE(std::abs(force - last), 1.01 * kStiffness * 1e-6);
    last = force;
  }
  EXPECT_GT(last, kStiffness * 0.01);
}

TEST(HapticContact, BeyondThePatchsBorderThereIsNoContact) {
  const double half = 0.03;
  const ToolPatch patch = PlanePatch(7, half, kStiffness);
  EXPECT_EQ(Press(patch, {half - 1e-4, 0, 0}).kind, ContactKind::kPress);
  EXPECT_EQ(Press(patch, {half, 0, 0.001}).kind, ContactKind::kPress);  // straight above the border
  EXPECT_EQ(Press(patch, {half + 2e-6, 0, 0.001}).kind, ContactKind::kNone);
  EXPECT_EQ(Press(patch, {half + 2e-6, half + 2e-6, 0.001}).kind, ContactKind::kNone);
  EXPECT_EQ(Press(patch, {half + 0.01, 0, -0.02}).kind, ContactKind::kNone);
  EXPECT_EQ(Press(patch, {10, 10, -10}).kind, ContactKind::kNone);
}

TEST(HapticContact, PointTipPressesOnlyBelowTheSurface) {
  const ToolPatch patch = PlanePatch(7, 0.03, kStiffness);
  EXPECT_EQ(Press(patch, {0, 0, 1e-9}, 0).kind, ContactKind::kNone);
  EXPECT_EQ(Press(patch, {0, 0, 0}, 0).kind, ContactKind::kNone);
  const HapticForce below = Press(patch, {0, 0, -0.002}, 0);
  EXPECT_NEAR(below.depth, 0.002, 1e-15);
  EXPECT_GT(below.reaction_W.z(), 0);
}

TEST(HapticContact, TipOnAFaceEdgeOrVertexHasADefinedDirection) {
  const ToolPatch patch = SpherePatch(7, 0.03, 0.05, kStiffness);
  const Vector3d a = patch.points[24].p_original_W, b = patch.points[25].p_original_W,
                 c = patch.points[32].p_original_W;
  const Vector3d centre(0, 0, -0.05);  // of the sphere, on which the curved surface lies
  for (const Vector3d& on_mesh : {a, Vector3d((a + b) / 2), Vector3d((a + b + c) / 3)}) {
    const Vector3d p = centre + 0.05 * (on_mesh - centre).normalized();
    const HapticForce result = Press(patch, p);
    EXPECT_EQ(result.kind, ContactKind::kPress);
    EXPECT_NEAR(result.depth, kRadius, 2e-5);
    EXPECT_NEAR(result.normal_W.norm(), 1, 1e-12);
    // The outward direction of the sphere there, within the interpolation's 1e-3.
    EXPECT_GT(result.normal_W.dot((p + Vector3d(0, 0, 0.05)).normalized()), 1 - 1e-3);
  }
}

TEST(HapticContact, WithoutVertexNormalsTheFacesOwnDecide) {
  ToolPatch patch = PlanePatch(7, 0.03, kStiffness);
  for (auto& point : patch.points) point.normal_W.setZero();
  for (const double z : {0.001, 0.0, -0.002}) {
    const HapticForce result = Press(patch, {0.001, 0.002, z});
    EXPECT_NEAR(result.depth, kRadius - z, 1e-15);
    EXPECT_LT((result.normal_W - Vector3d::UnitZ()).norm(), 1e-12);
  }
}

TEST(HapticContact, UnusableTrianglesAreLeftOutAndOpenNoBorder) {
  ToolPatch patch = PlanePatch(7, 0.03, kStiffness);
  // A triangle without area along the edge from point 23 to 24, between its two neighbours.
  const std::uint8_t middle = static_cast<std::uint8_t>(patch.point_count++);
  patch.points[middle] = patch.points[24];
  patch.nodes[patch.node_count++] = patch.nodes[24];
  patch.points[middle].p_original_W =
      (patch.points[23].p_original_W + patch.points[24].p_original_W) / 2;
  for (int t = 0; t < patch.triangle_count; ++t) {
    const auto& c = patch.triangles[t];
    if (c == std::array<std::uint8_t, 3>{16, 17, 24}) continue;
    // The triangle above the edge is split at its middle; the one below keeps the whole edge.
    if (c == std::array<std::uint8_t, 3>{23, 24, 31}) {
      patch.triangles[t] = {23, middle, 31};
      patch.triangles[patch.triangle_count++] = {middle, 24, 31};
      patch.triangles[patch.triangle_count++] = {23, 24, middle};
      break;
    }
  }
  patch.triangles[patch.triangle_count++] = {200, 1, 2};
  patch.triangles[patch.triangle_count++] = {3, 3, 3};
  HandRandom random(6);
  const Vector3d from = patch.points[23].p_original_W, to = patch.points[24].p_original_W;
  for (int i = 0; i < 200; ++i) {
    const double z = random.Uniform(-0.01, 0.002);
    const Vector3d p =
        from + random.Uniform(0, 1) * (to - from) + Vector3d(0, random.Uniform(-1e-4, 1e-4), z);
    EXPECT_NEAR(Press(patch, p).depth, kRadius - z, 1e-12);
  }

  // Points that are not finite take their triangles out, and nothing else.
  patch.points[0].p_original_W.setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_NEAR(Press(patch, {0.001, 0.002, 0}).depth, kRadius, 1e-12);
}

// Presses a thin part deeper than its centre of curvature. The closest point of the released
// surface then lies on the sides, and the foot on the side of the press is not in equilibrium.
TEST(HapticContact, APressThroughTheCentreOfCurvatureKeepsItsSide) {
  constexpr double kCurvature = 0.006, kStep = 1e-4;
  const ToolPatch patch = SpherePatch(7, 0.005, kCurvature, kStiffness);
  HapticContact contact;
  contact.SetPatch(patch);
  const auto press = [&](double height) { return contact.Evaluate(At({2e-4, 1e-4, height})); };
  Vector3d last = Vector3d::Zero();
  const auto expect_continuous = [&](double height) {
    const HapticForce result = press(height);
    // The press changes by k per step, and the normal may turn by 3.6 degrees (0.064 rad) per step.
    EXPECT_LT((result.reaction_W - last).norm(),
              1.1 * kStiffness * kStep + 0.064 * result.reaction_W.norm())
        << height;
    last = result.reaction_W;
    return result;
  };
  const int steps = static_cast<int>((kRadius + 1.5 * kCurvature) / kStep);
  for (int i = 0; i <= steps; ++i) expect_continuous(kRadius - i * kStep);
  EXPECT_GT(last.z(), 0.9 * kStiffness * steps * kStep);  // all but along the axis
  // The next patch of the same surface changes nothing.
  // NOLINTNEXTLINE(performance-unnecessary-copy-initialization): another object is the point
  const ToolPatch next = patch;
  contact.SetPatch(next);
  expect_continuous(kRadius - steps * kStep);
  for (int i = steps; i >= -1; --i) expect_continuous(kRadius - i * kStep);
  EXPECT_EQ(last, Vector3d::Zero());
}

TEST(HapticContact, EmptyAndDistantPatchesGiveNothing) {
  ToolPatch empty;
  EXPECT_EQ(Press(empty, {0, 0, 0}).kind, ContactKind::kNone);
  empty.organ = 0;
  EXPECT_EQ(Press(empty, {0, 0, 0}).kind, ContactKind::kNone);
  HapticContact contact;  // before any patch
  EXPECT_EQ(contact.Evaluate(At(Vector3d::Zero())).kind, ContactKind::kNone);
  ToolPatch wild = PlanePatch(7, 0.03, kStiffness);
  wild.point_count = 1000;
  wild.triangle_count = 1000;
  EXPECT_EQ(Press(wild, {0.001, 0.002, 0}).kind, ContactKind::kPress);
}

// A triple buffer's reader has given the last patch back when it takes the next.
TEST(HapticContact, APatchMayChangeOnceTheNextHasArrived) {
  for (const int written_over : {0, 1}) {
    ToolPatch before = PlanePatch(8, 0.03, kStiffness);
    HapticContact contact;
    contact.SetPatch(before);
    ASSERT_EQ(contact.Evaluate(At({0, 0, -0.005})).kind, ContactKind::kPress);
    before.organ = written_over;
    ToolPatch next = PlanePatch(8, 0.03, kStiffness);
    next.organ = 1 - written_over;
    contact.SetPatch(next);
    EXPECT_EQ(contact.contact_point().organ, next.organ == 0 ? 0 : -1)
        << "a contact lasts on its organ and ends with another's patch";
  }
}

TEST(HapticContact, APressNeverPullsTheHandIntoTheTissue) {
  ToolPatch patch = PlanePatch(7, 0.03, kStiffness);
  for (ReactionNode& node : patch.nodes) {
    node.k1 = 1;
    node.neighbour_count = 1;  // a taut spring that lifts the tissue, and so sucks the tip in
    node.neighbours[0] = {.edge = {0.001, 0, -0.01}, .rest_length = 0.001, .k2 = 100};
  }
  const HapticForce result = Press(patch, {0.001, 0.002, 0});
  for (ReactionNode& node : patch.nodes) node.neighbours[0].edge.z() = 0.02;
  ASSERT_LT(ForceOnHand(patch.nodes[0], {0, 0, -kRadius}).z(), 0);
  const HapticForce sucked = Press(patch, {0.001, 0.002, 0});
  EXPECT_NEAR(sucked.reaction_W.z(), 0, 1e-15);
  EXPECT_EQ(sucked.kind, ContactKind::kPress);
  EXPECT_GT(result.reaction_W.z(), 0);
}

TEST(HapticContact, GraspFollowsTheJawAndLetsGoWithinTheTick) {
  ToolPatch patch = PlanePatch(7, 0.03, kStiffness);
  patch.kind = ContactKind::kGrasp;
  patch.grasp_node.k1 = 200;
  patch.p_grasp_T = Vector3d(0, 0, -0.001);
  patch.p_original_W = Vector3d(0, 0, 0.004);
  HapticContact contact;
  contact.SetPatch(patch);
  const Isometry3d X_WT =
      Eigen::Translation3d(0, 0, 0.02) * Eigen::AngleAxisd(0.5, Vector3d::UnitX());

  const HapticForce held = contact.Evaluate({.X_WT = X_WT, .jaw = 0.1, .tip_radius = kRadius});
  EXPECT_EQ(held.kind, ContactKind::kGrasp);
  const Vector3d delta = X_WT * patch.p_grasp_T - patch.p_original_W;
  EXPECT_LT((held.reaction_W + 200 * delta).norm(), 1e-14);
  EXPECT_LT(held.reaction_W.z(), 0);  // lifted tissue pulls the hand down

  EXPECT_EQ(contact.Evaluate({.X_WT = X_WT, .jaw = 0.5, .tip_radius = kRadius}).kind,
            ContactKind::kGrasp);
  const HapticForce opened = contact.Evaluate({.X_WT = X_WT, .jaw = 0.51, .tip_radius = kRadius});
  EXPECT_EQ(opened.kind, ContactKind::kNone);
  EXPECT_EQ(opened.reaction_W, Vector3d::Zero());
  // Opened while pressed into the surface, the tip still presses.
  EXPECT_EQ(contact.Evaluate(At(Vector3d::Zero())).kind, ContactKind::kPress);
}

TEST(HapticContact, DoesNotDependOnWhereTheWorldsOriginIs) {
  HandRandom random(8);
  const ToolPatch patch = SpherePatch(7, 0.03, 0.05, kStiffness);
  const Isometry3d X =
      Eigen::Translation3d(3, -7, 11) * Eigen::AngleAxisd(1.3, Vector3d(1, 2, 3).normalized());
  ToolPatch moved = patch;
  for (auto& point : moved.points) {
    point.p_original_W = X * point.p_original_W;
    point.normal_W = X.linear() * point.normal_W;
  }
  for (int i = 0; i < 200; ++i) {
    const Vector3d p(random.Uniform(-0.015, 0.015), random.Uniform(-0.015, 0.015),
                     random.Uniform(-0.01, 0.001));
    // Coordinates of 11 m have 2e-15 m of round-off; 120 N/m.
    EXPECT_LT((Press(moved, X * p).reaction_W - X.linear() * Press(patch, p).reaction_W).norm(),
              1e-11);
  }
}

}  // namespace
}  // namespace hpdm
