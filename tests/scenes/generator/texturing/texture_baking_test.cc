#include "scenes/generator/texturing/texture_baking.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "scenes/generator/mesh_assets.h"
#include "scenes/generator/texturing/texture_atlas.h"

namespace hpdm {
namespace {

/// Samples as a graphics card at (u, v): bilinear, one component, 0..1.
double Lookup(const Image& image, const Eigen::RowVector2d& uv, int component) {
  const double x = uv.x() * image.width - 0.5, y = (1 - uv.y()) * image.height - 0.5;
  const int i = static_cast<int>(x), j = static_cast<int>(y);
  const double s = x - i, t = y - j;
  return ((1 - t) * ((1 - s) * image.At(i, j)[component] + s * image.At(i + 1, j)[component]) +
          t * ((1 - s) * image.At(i, j + 1)[component] + s * image.At(i + 1, j + 1)[component])) /
         255;
}

TEST(TextureBaking, ShowsTheColourOfEveryPointAcrossAllSeams) {
  const SurfaceMesh mesh = MakeMeshAsset("liver_274");
  const Vector3d low = mesh.vertices.colwise().minCoeff().transpose();
  const Vector3d size = mesh.vertices.colwise().maxCoeff().transpose() - low;
  const SurfaceColour place = [&](const Vector3d& p) {
    return Vector3d(0.1 * Vector3d::Ones() + 0.8 * (p - low).cwiseQuotient(size));
  };
  const Image texture = BakeTexture(mesh, kTextureSize, place);
  // Corners, points of sides and inner ones: charts meet at the first two.
  const std::array<Vector3d, 5> weights = {Vector3d(1, 0, 0), Vector3d(0.5, 0.5, 0),
                                           Vector3d(0.2, 0, 0.8), Vector3d(0.4, 0.3, 0.3),
                                           Vector3d(0, 0.9, 0.1)};
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    for (const Vector3d& w : weights) {
      Vector3d p = Vector3d::Zero();
      Eigen::RowVector2d uv(0, 0);
      for (int c = 0; c < 3; ++c) {
        p += w[c] * mesh.vertices.row(mesh.triangles(t, c)).transpose();
        uv += w[c] * mesh.texture_coordinates.row(3 * t + c);
      }
      for (int k = 0; k < 3; ++k) {
        // Bytes round to half a step, and a texel beside a sharp edge of this coarse surface
        // continues one of the triangles there: 1.5 texels of 0.8 mm, shortened up to sixfold by
        // the projection, on 134 mm or more are 0.8 * 1.5 * 0.8 / 134 * 6 = 0.04.
        const double error = std::abs(Lookup(texture, uv, k) - place(p)[k]);
        const bool is_inner = w.minCoeff() > 0.2;
        EXPECT_LT(error, is_inner ? 0.006 : 0.04) << "triangle " << t << " component " << k;
      }
    }
  }
}

TEST(TextureBaking, LeavesNoPixelToABackground) {
  const Image texture = BakeTexture(MakeMeshAsset("liver_274"), 100,
                                    [](const Vector3d&) { return Vector3d(0.2, 0.4, 0.6); });
  ASSERT_EQ(texture.rgb.size(), 3u * 100 * 100);
  for (int y = 0; y < 100; ++y) {
    for (int x = 0; x < 100; ++x) {
      ASSERT_EQ(texture.At(x, y)[0], 51);
      ASSERT_EQ(texture.At(x, y)[1], 102);
      ASSERT_EQ(texture.At(x, y)[2], 153);
    }
  }
}

}  // namespace
}  // namespace hpdm
