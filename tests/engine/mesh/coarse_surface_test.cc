#include "engine/mesh/coarse_surface.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/shapes.h"

namespace hpdm {
namespace {

TEST(CoarseSurface, HasFewLargeTrianglesNearTheSurface) {
  const Vector3d radii(0.1, 0.08, 0.05);
  const SurfaceMesh fine = Ellipsoid(radii, 5);
  const std::optional<CoarseSurface> coarse = CoarseSurface::Of(fine);
  ASSERT_TRUE(coarse);
  double area = 0, farthest = 0;
  for (Eigen::Index t = 0; t < coarse->triangles().rows(); ++t) {
    const Vector3d a = fine.vertices.row(coarse->triangles()(t, 0));
    const Vector3d b = fine.vertices.row(coarse->triangles()(t, 1));
    const Vector3d c = fine.vertices.row(coarse->triangles()(t, 2));
    area += (b - a).cross(c - a).norm() / 2;
    const Vector3d middle = (a + b + c) / 3;
    // Distance from the ellipsoid to first order.
    const double level = middle.cwiseQuotient(radii).squaredNorm() - 1;
    const double slope = 2 * middle.cwiseQuotient(radii.cwiseProduct(radii)).norm();
    farthest = std::max(farthest, std::abs(level) / slope);
  }
  EXPECT_NEAR(area / static_cast<double>(coarse->triangles().rows()), CoarseSurface::kTriangleArea,
              0.2 * CoarseSurface::kTriangleArea);
  EXPECT_LT(farthest, CoarseSurface::kMaxError);
  const SurfacePoint top = coarse->Closest(Vector3d(0, 0, 0.06), 0.02);
  ASSERT_GE(top.triangle, 0);
  EXPECT_NEAR(top.Position(fine.vertices, coarse->triangles()).z(), 0.05, 0.001);
}

TEST(CoarseSurface, AMeshOfLargeTrianglesHasNone) {
  EXPECT_FALSE(CoarseSurface::Of(Ellipsoid(Vector3d(0.1, 0.08, 0.05), 2)));
}

}  // namespace
}  // namespace hpdm
