#include "engine/contact/patch_surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "haptics/device/hand_script.h"
#include "tests/support/contact_patches.h"
#include "tests/support/random_vector.h"

namespace hpdm {
namespace {

constexpr double kStiffness = 120;  // N/m
constexpr double kFar = 1;          // m, a reach that never leaves anything out

bool Foot(const ToolPatch& patch, const Vector3d& p_W, SurfaceFoot* foot) {
  PatchSurface surface;
  surface.Build(patch);
  return surface.FindFoot(p_W, kFar, foot);
}

// Returns the closed octahedron (8 triangles) or cube (12) of half width h around the origin, with
// normals through the vertices.
ToolPatch Solid(bool cube, double h) {
  ToolPatch patch;
  patch.organ = 0;
  patch.kind = ContactKind::kPress;
  const auto point = [&](double x, double y, double z) {
    PatchPoint& p = patch.points[patch.point_count++];
    p.p_original_W = h * Vector3d(x, y, z);
    p.normal_W = p.p_original_W.normalized();
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
    // Points exactly over a corner, an edge's middle and a face's middle.
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

TEST(PatchSurface, GapOverATriangulatedSphereIsThatOverTheSphere) {
  HandRandom random(4);
  const double R = 0.05;
  const ToolPatch patch = SpherePatch(7, 0.03, R, kStiffness);
  for (int i = 0; i < 2000; ++i) {
    const Vector3d direction =
        Vector3d(random.Uniform(-0.4, 0.4), random.Uniform(-0.4, 0.4), 1).normalized();
    const double gap = random.Uniform(-0.02, 0.02);
    SurfaceFoot foot;
    ASSERT_TRUE(Foot(patch, Vector3d(0, 0, -R) + (R + gap) * direction, &foot));
    // Facets of 14 mm lie up to edge^2 / (8 R) = 0.5 mm inside the sphere, the curved surface a
    // twentieth of that.
    EXPECT_NEAR(foot.gap, gap, 2.5e-5);
    // The normals meet at the centre, so the foot is on the ray: only the interpolation is left.
    EXPECT_GT(foot.normal_W.dot(direction), 1 - 1e-3);
  }
}

}  // namespace
}  // namespace hpdm
