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
constexpr double kFar = 1;          // m, a reach that never leaves anything out

Vector3d RandomVector(HandRandom* random, double size) {
  return {random->Uniform(-size, size), random->Uniform(-size, size), random->Uniform(-size, size)};
}

TipPose At(const Vector3d& p_tip_W, double radius = kRadius) {
  return {.X_WT = Isometry3d(Eigen::Translation3d(p_tip_W)), .tip_radius = radius};
}

HapticForce Press(const ToolPatch& patch, const Vector3d& p_tip_W, double radius = kRadius) {
  HapticContact contact;
  contact.SetPatch(patch);
  return contact.Evaluate(At(p_tip_W, radius));
}

bool Foot(const ToolPatch& patch, const Vector3d& p_W, SurfaceFoot* foot) {
  PatchSurface surface;
  surface.Build(patch);
  return surface.FindFoot(p_W, kFar, foot);
}

// The closed octahedron, 8 triangles, or the cube, 12, of half width h about the origin, with
// normals through the vertices.
ToolPatch Solid(bool cube, double h) {
  ToolPatch patch;
  patch.organ = 0;
  patch.kind = ContactKind::kPress;
  const auto point = [&](double x, double y, double z) {
    PatchPoint& p = patch.points[patch.point_count++];
    p.p_original_W = h * Vector3d(x, y, z);
    p.normal_W = p.p_original_W.normalized();
    p.node.k1 = kStiffness;
  };
  const auto triangle = [&](int a, int b, int c) {
    const Vector3d pa = patch.points[a].p_original_W, pb = patch.points[b].p_original_W,
                   pc = patch.points[c].p_original_W;
    if ((pb - pa).cross(pc - pa).dot(pa + pb + pc) < 0) std::swap(b, c);
    patch.mesh_triangles[patch.triangle_count] = patch.triangle_count;
    patch.triangles[patch.triangle_count++] = {
        static_cast<std::uint8_t>(a), static_cast<std::uint8_t>(b), static_cast<std::uint8_t>(c)};
  };
  if (cube) {
    for (int i = 0; i < 8; ++i) point(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    for (int axis = 0; axis < 3; ++axis) {
      const int u = 1 << ((axis + 1) % 3), v = 1 << ((axis + 2) % 3);
      for (const int side : {0, 1 << axis}) {
        triangle(side, side | u, side | u | v);
        triangle(side, side | u | v, side | v);
      }
    }
  } else {
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d e = Vector3d::Unit(axis);
      point(e.x(), e.y(), e.z());
      point(-e.x(), -e.y(), -e.z());
    }
    for (int i = 0; i < 8; ++i) triangle(i & 1, 2 + (i >> 1 & 1), 4 + (i >> 2 & 1));
  }
  return patch;
}

TEST(PatchSurface, GapOverAPlaneIsTheHeight) {
  HandRandom random(2);
  const ToolPatch patch = PlanePatch(8, 0.03, kStiffness);
  for (int i = 0; i < 1000; ++i) {
    // Within the rows that 96 triangles cover.
    const Vector3d p(random.Uniform(-0.02, 0.02), random.Uniform(-0.03, 0.02),
                     random.Uniform(-0.05, 0.05));
    SurfaceFoot foot;
    ASSERT_TRUE(Foot(patch, p, &foot));
    EXPECT_NEAR(foot.gap, p.z(), 1e-15);
    EXPECT_LT((foot.normal_W - Vector3d::UnitZ()).norm(), 1e-15);
    Vector3d q = Vector3d::Zero();
    for (int k = 0; k < 3; ++k) q += foot.weights[k] * patch.points[foot.corners[k]].p_original_W;
    EXPECT_LT((q - Vector3d(p.x(), p.y(), 0)).norm(), 1e-14);
  }
}

TEST(PatchSurface, SignIsRightOverFacesEdgesAndCornersOfSharpSolids) {
  HandRandom random(3);
  const double h = 0.01;
  for (const bool cube : {true, false}) {
    const ToolPatch patch = Solid(cube, h);
    int checked = 0;
    for (int i = 0; i < 20'000; ++i) {
      const Vector3d p = RandomVector(&random, 1.3 * h);
      // Height over the solid's boundary in its own norm (maximum or sum of the coordinates).
      const double size = cube ? p.cwiseAbs().maxCoeff() : p.cwiseAbs().sum();
      if (size < 0.7 * h || std::abs(size - h) < 1e-9) continue;
      SurfaceFoot foot;
      ASSERT_TRUE(Foot(patch, p, &foot)) << p.transpose();
      EXPECT_EQ(foot.gap > 0, size > h) << p.transpose();
      EXPECT_NEAR(foot.normal_W.norm(), 1, 1e-12);
      EXPECT_GT(foot.normal_W.dot(p), 0) << p.transpose();
      ++checked;
    }
    EXPECT_GT(checked, 1000);
    // Exactly over a corner, an edge's middle and a face's middle.
    for (const Vector3d& direction :
         {patch.points[0].p_original_W,
          Vector3d(patch.points[0].p_original_W + patch.points[2].p_original_W),
          Vector3d(patch.points[0].p_original_W + patch.points[2].p_original_W +
                   patch.points[4].p_original_W)}) {
      const double size = cube ? direction.cwiseAbs().maxCoeff() : direction.cwiseAbs().sum();
      for (const double scale : {0.9, 1.1}) {
        SurfaceFoot foot;
        ASSERT_TRUE(Foot(patch, scale * h / size * direction, &foot));
        EXPECT_EQ(foot.gap > 0, scale > 1);
      }
    }
  }
}

TEST(PatchSurface, GapOverATriangulatedSphereIsWithinItsSagitta) {
  HandRandom random(4);
  const double R = 0.05;
  const ToolPatch patch = SpherePatch(7, 0.03, R, kStiffness);
  for (int i = 0; i < 2000; ++i) {
    const Vector3d direction =
        Vector3d(random.Uniform(-0.4, 0.4), random.Uniform(-0.4, 0.4), 1).normalized();
    const double gap = random.Uniform(-0.02, 0.02);
    SurfaceFoot foot;
    ASSERT_TRUE(Foot(patch, Vector3d(0, 0, -R) + (R + gap) * direction, &foot));
    // Facets of 14 mm lie at most edge^2 / (8 R) = 0.5 mm inside the sphere.
    EXPECT_GT(foot.gap, gap - 1e-9);
    EXPECT_LT(foot.gap, gap + 5.1e-4);
    // The normals meet at the centre, so the foot is on the ray: only the interpolation is left.
    EXPECT_GT(foot.normal_W.dot(direction), 1 - 1e-3);
  }
}

TEST(HapticContact, DepthAndForceOfAPressIntoAPlane) {
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

// Sliding in steps of 1 um over many edges, with the tip's centre above and far below the surface.
// On the sphere the closest point itself would jump there by more than a millimetre.
TEST(HapticContact, ForceIsContinuousWhileSliding) {
  const double R = 0.05;
  for (const bool sphere : {false, true}) {
    ToolPatch patch =
        sphere ? SpherePatch(7, 0.03, R, kStiffness) : PlanePatch(7, 0.03, kStiffness);
    HandRandom random(5);
    const double kHigh = 1.5 * kStiffness;
    for (int i = 0; i < patch.point_count; ++i) {
      patch.points[i].node.k1 = random.Uniform(kStiffness, kHigh);
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
  for (const Vector3d& p : {a, Vector3d((a + b) / 2), Vector3d((a + b + c) / 3)}) {
    const HapticForce result = Press(patch, p);
    EXPECT_EQ(result.kind, ContactKind::kPress);
    EXPECT_NEAR(result.depth, kRadius, 1e-12);
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

// A thin part of an organ, pressed deeper than its centre of curvature: the closest point of the
// released surface is then on the sides, and the foot on the side of the press is no equilibrium.
TEST(HapticContact, APressThroughTheCentreOfCurvatureKeepsItsSide) {
  constexpr double kCurvature = 0.006, kStep = 1e-4;
  const ToolPatch patch = SpherePatch(7, 0.005, kCurvature, kStiffness);
  HapticContact contact;
  contact.SetPatch(patch);
  const auto press = [&](double height) { return contact.Evaluate(At({2e-4, 1e-4, height})); };
  Vector3d last = Vector3d::Zero();
  const auto expect_continuous = [&](double height) {
    const HapticForce result = press(height);
    // The press itself is k a step, and the normal may turn by 3.6 degrees (0.064 rad) in one.
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
  for (auto& point : patch.points) {
    point.node.k1 = 1;
    point.node.neighbour_count = 1;  // a taut spring that lifts the tissue, and so sucks the tip in
    point.node.neighbours[0] = {.edge = {0.001, 0, -0.01}, .rest_length = 0.001, .k2 = 100};
  }
  const HapticForce result = Press(patch, {0.001, 0.002, 0});
  ReactionNode node = patch.points[0].node;
  for (auto& point : patch.points) point.node.neighbours[0].edge.z() = 0.02;
  node = patch.points[0].node;
  ASSERT_LT(ForceOnHand(node, {0, 0, -kRadius}).z(), 0);
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
  // Opened while pressed into the surface: what is left is the press.
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
