#include "engine/mesh/polygon.h"

#include <gtest/gtest.h>

#include <chrono>
#include <random>

namespace hpdm {
namespace {

/// Twice the area of each triangle along z; all positive when none is turned over.
std::vector<double> Areas(const Points& corners, const std::vector<std::array<int, 3>>& triangles) {
  std::vector<double> areas;
  for (const auto& [i, j, k] : triangles) {
    const Vector3d a = corners.row(i), b = corners.row(j), c = corners.row(k);
    areas.push_back((b - a).cross(c - a).z() / 2);
  }
  return areas;
}

double Sum(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum;
}

TEST(Polygon, AConcavePolygonIsCoveredWithoutOverlap) {
  Points arrow(5, 3);
  arrow << 0, 0, 0, 2, 0, 0, 2, 2, 0, 1, 0.5, 0, 0, 2, 0;
  for (const double scale : {1e-6, 1.0, 1e6}) {
    const Points scaled = arrow * scale;
    const auto triangles = TriangulatePolygon(scaled);
    ASSERT_EQ(triangles.size(), 3u);
    const auto areas = Areas(scaled, triangles);
    for (const double area : areas) EXPECT_GT(area, 0);
    // 2 x 2 less the notch of base 2 and height 1.5, up to rounding.
    EXPECT_NEAR(Sum(areas), 2.5 * scale * scale, 1e-12 * scale * scale);
  }
}

TEST(Polygon, ABridgeToAHoleIsKeptOpen) {
  // A square of side 3 with a hole of side 1, cut open along the bridge 0 - 5.
  Points ring(10, 3);
  ring << 0, 0, 0, 3, 0, 0, 3, 3, 0, 0, 3, 0, 0, 0, 0,  //
      1, 1, 0, 1, 2, 0, 2, 2, 0, 2, 1, 0, 1, 1, 0;
  const auto triangles = TriangulatePolygon(ring);
  ASSERT_EQ(triangles.size(), 8u);
  const auto areas = Areas(ring, triangles);
  for (const double area : areas) EXPECT_GE(area, 0);
  EXPECT_NEAR(Sum(areas), 8, 1e-12);
}

TEST(Polygon, ANoisyPolygonStillGivesAllItsTrianglesInBoundedTime) {
  std::mt19937 random(11);
  std::normal_distribution<double> coordinate;
  Points tangle(256, 3);
  for (Eigen::Index i = 0; i < tangle.size(); ++i) tangle.data()[i] = coordinate(random);
  const auto start = std::chrono::steady_clock::now();
  const auto triangles = TriangulatePolygon(tangle);
  // At most 8 n^2 = 524,288 point tests: milliseconds; a second leaves room for sanitizers.
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(1));
  EXPECT_EQ(triangles.size(), 254u);
}

TEST(Polygon, APolygonWithoutAreaStillGivesAllItsTriangles) {
  EXPECT_EQ(TriangulatePolygon(Points::Zero(6, 3)).size(), 4u);
}

}  // namespace
}  // namespace hpdm
