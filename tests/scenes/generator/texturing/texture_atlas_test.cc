#include "scenes/generator/texturing/texture_atlas.h"

#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "engine/mesh/mesh_edges.h"
#include "scenes/generator/mesh_assets.h"

namespace hpdm {
namespace {

using Index = Eigen::Index;

/// The part of the surface around each triangle that the atlas does not cut: triangles whose common
/// corners have common coordinates.
std::vector<int> ChartOf(const SurfaceMesh& mesh) {
  DisjointSets sets(static_cast<int>(mesh.triangles.rows()));
  std::map<std::pair<double, double>, int> first;
  for (Index row = 0; row < mesh.texture_coordinates.rows(); ++row) {
    const auto uv = mesh.texture_coordinates.row(row);
    const int t = static_cast<int>(row / 3);
    sets.Merge(first.try_emplace({uv.x(), uv.y()}, t).first->second, t);
  }
  std::vector<int> chart;
  for (int t = 0; t < static_cast<int>(mesh.triangles.rows()); ++t) chart.push_back(sets.Find(t));
  return chart;
}

/// Texels whose centre each triangle covers: calls visit(triangle, x, y).
template <typename Visit>
void ForEachTexel(const TextureCoordinates& uv, Visit visit) {
  for (Index t = 0; 3 * t < uv.rows(); ++t) {
    const Eigen::Matrix<double, 3, 2> corners = kTextureSize * uv.middleRows<3>(3 * t);
    const Eigen::RowVector2d low = corners.colwise().minCoeff(),
                             high = corners.colwise().maxCoeff();
    for (int y = static_cast<int>(low.y()); y < high.y(); ++y) {
      for (int x = static_cast<int>(low.x()); x < high.x(); ++x) {
        bool inside = true;
        for (int side = 0; side < 3; ++side) {
          const Eigen::RowVector2d a = corners.row(side), b = corners.row((side + 1) % 3);
          inside =
              inside && (b.x() - a.x()) * (y + 0.5 - a.y()) > (b.y() - a.y()) * (x + 0.5 - a.x());
        }
        if (inside) visit(static_cast<int>(t), x, y);
      }
    }
  }
}

class TextureAtlas : public testing::TestWithParam<const char*> {
 protected:
  const SurfaceMesh mesh_ = MakeMeshAsset(GetParam());
};

INSTANTIATE_TEST_SUITE_P(Assets, TextureAtlas,
                         testing::Values("liver_274", "liver_1332", "liver_5000", "stomach_2132",
                                         "stomach_hollow", "gallbladder"),
                         [](const auto& name) { return std::string(name.param); });

TEST_P(TextureAtlas, ProjectsEveryTriangleAtOneScaleWithoutTurningIt) {
  const Index outer = std::string(GetParam()) == "stomach_hollow" ? 2132
                      : std::string(GetParam()) == "gallbladder"  ? 900
                                                                  : mesh_.triangles.rows();
  double scale = 0;
  for (Index t = 0; t < mesh_.triangles.rows(); ++t) {
    // The map from the triangle's own plane to the picture, for lengths.
    const Vector3d a = mesh_.vertices.row(mesh_.triangles(t, 0));
    const Vector3d b = mesh_.vertices.row(mesh_.triangles(t, 1)).transpose() - a;
    const Vector3d c = mesh_.vertices.row(mesh_.triangles(t, 2)).transpose() - a;
    const auto uv = mesh_.texture_coordinates.middleRows<3>(3 * t);
    Eigen::Matrix2d plane, picture;
    const Vector3d right = b.normalized();
    const Vector3d up = b.cross(c).normalized().cross(right);
    plane << b.dot(right), c.dot(right), b.dot(up), c.dot(up);
    picture.col(0) = (uv.row(1) - uv.row(0)).transpose();
    picture.col(1) = (uv.row(2) - uv.row(0)).transpose();
    const Eigen::Matrix2d map = picture * plane.inverse();
    EXPECT_GT(map.determinant(), 0) << "triangle " << t;
    const Eigen::Vector2d stretch = Eigen::JacobiSVD<Eigen::Matrix2d>(map).singularValues();
    if (t == 0) scale = stretch[0];
    // A projection keeps lengths across the slope; the cavity has a quarter of the texels.
    // Round-off of the inverse of the flattest triangles.
    EXPECT_NEAR(stretch[0], t < outer ? scale : scale / 4, 1e-6 * scale) << "triangle " << t;
    // The cutter's bound for small charts.
    EXPECT_GT(stretch[1], 0.15 * stretch[0] * (1 - 1e-6)) << "triangle " << t;
  }
  // A liver of 0.08 m^2 on 512 x 512 texels has 0.5 mm a texel at best; seen obliquely and with
  // gutters it must stay below 0.9, the hollow stomach of 0.14 m^2 below 1.2.
  EXPECT_LT(1 / (scale * kTextureSize), 1.2e-3);
}

TEST_P(TextureAtlas, GivesEveryChartAPlaceOfItsOwnWithAGutter) {
  const std::vector<int> chart = ChartOf(mesh_);
  std::vector<int> owner(kTextureSize * kTextureSize, -1), painter = owner;
  int shared = 0, covered = 0;
  ForEachTexel(mesh_.texture_coordinates, [&](int t, int x, int y) {
    ASSERT_TRUE(x >= kTextureGutter && x < kTextureSize - kTextureGutter);
    ASSERT_TRUE(y >= kTextureGutter && y < kTextureSize - kTextureGutter);
    const auto texel = static_cast<std::size_t>(y * kTextureSize + x);
    shared += painter[texel] >= 0;
    ++covered;
    painter[texel] = t;
    owner[texel] = chart[static_cast<std::size_t>(t)];
  });
  // Charts do not fold but for a sliver of the coarsest liver where three charts meet.
  EXPECT_LE(shared, std::string(GetParam()) == "liver_274" ? 1 : 0);
  EXPECT_GT(covered, 0.35 * kTextureSize * kTextureSize);
  // Centres of texels of two charts are at least both gutters apart, less half a texel at each.
  const int reach = 2 * kTextureGutter - 1;
  for (int y = kTextureGutter; y < kTextureSize - 2 * kTextureGutter; ++y) {
    for (int x = 2 * kTextureGutter; x < kTextureSize - 2 * kTextureGutter; ++x) {
      const int own = owner[static_cast<std::size_t>(y * kTextureSize + x)];
      if (own < 0) continue;
      for (int step = -reach; step <= reach; ++step) {
        for (const auto& [i, j] : {std::pair(step, 0), std::pair(step, reach)}) {
          const int other = owner[static_cast<std::size_t>((y + j) * kTextureSize + x + i)];
          ASSERT_TRUE(other < 0 || other == own) << x << " " << y;
        }
      }
    }
  }
}

}  // namespace
}  // namespace hpdm
