#include "engine/mesh/collision.h"

#include <gtest/gtest.h>

#include <random>

#include "engine/mesh/closest_point.h"
#include "engine/mesh/surface_topology.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

Vector3d RandomPoint(std::mt19937* random, double size) {
  Vector3d p;
  for (double& x : p) x = size * ((*random)() / 2147483648.0 - 1);
  return p;
}

TEST(ClosestPoint, NoPointOfTheTriangleIsCloser) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 20'000; ++trial) {
    const Vector3d a = RandomPoint(&random, 1), b = RandomPoint(&random, 1),
                   c = RandomPoint(&random, 1), p = RandomPoint(&random, 2);
    const TrianglePoint closest = ClosestOnTriangle(p, a, b, c);
    EXPECT_GE(closest.barycentric.minCoeff(), 0);
    EXPECT_NEAR(closest.barycentric.sum(), 1, 1e-12);
    // Closest in a convex set if and only if no corner lies ahead; slivers cost some digits.
    for (const Vector3d& corner : {a, b, c}) {
      EXPECT_LE((p - closest.point).dot(corner - closest.point), 1e-9);
    }
  }
}

TEST(ClosestPoint, DegenerateTrianglesGiveAPointOfThem) {
  const Vector3d a(0, 0, 0), b(1, 0, 0), p(0.3, 1, 0);
  EXPECT_NEAR((ClosestOnTriangle(p, a, b, a).point - Vector3d(0.3, 0, 0)).norm(), 0, 1e-15);
  EXPECT_NEAR((ClosestOnTriangle(p, a, a, b).point - Vector3d(0.3, 0, 0)).norm(), 0, 1e-15);
  EXPECT_EQ(ClosestOnTriangle(p, b, b, b).point, b);
}

TEST(ClosestPoint, SegmentPairIsNoFartherThanAnySampledPair) {
  std::mt19937 random(2);
  for (int trial = 0; trial < 300; ++trial) {
    const Vector3d a = RandomPoint(&random, 1), b = RandomPoint(&random, 1),
                   c = RandomPoint(&random, 1), s = RandomPoint(&random, 2),
                   e = RandomPoint(&random, 2);
    const SegmentTrianglePair pair = ClosestSegmentTriangle(s, e, a, b, c);
    const Vector3d on_segment = s + pair.along * (e - s);
    EXPECT_NEAR((pair.on_triangle.point - on_segment).squaredNorm(), pair.squared_distance, 1e-12);
    for (int i = 0; i <= 50; ++i) {
      const Vector3d q = s + i / 50.0 * (e - s);
      const double distance = (ClosestOnTriangle(q, a, b, c).point - q).norm();
      EXPECT_LE(std::sqrt(pair.squared_distance), distance + 1e-12);
    }
  }
}

class SurfaceTreeTest : public testing::Test {
 protected:
  SurfaceMesh mesh_ = Ellipsoid(Vector3d(0.1, 0.07, 0.05), 3);
  SurfaceTree tree_{mesh_.vertices, mesh_.triangles};

  SurfaceHit BruteForce(const Points& vertices, const Vector3d& p) const {
    SurfaceHit best;
    best.distance = 1e9;
    for (Eigen::Index t = 0; t < mesh_.triangles.rows(); ++t) {
      const TrianglePoint closest = ClosestOnTriangle(p, vertices.row(mesh_.triangles(t, 0)),
                                                      vertices.row(mesh_.triangles(t, 1)),
                                                      vertices.row(mesh_.triangles(t, 2)));
      const double distance = (closest.point - p).norm();
      if (distance < best.distance)
        best = {{static_cast<int>(t), closest.barycentric}, distance, 0};
    }
    return best;
  }
};

TEST_F(SurfaceTreeTest, ClosestAgreesWithAllTriangles) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 200; ++trial) {
    const Vector3d p = RandomPoint(&random, 0.15);
    EXPECT_NEAR(tree_.Closest(p, 1).distance, BruteForce(mesh_.vertices, p).distance, 1e-15);
  }
}

TEST_F(SurfaceTreeTest, ClosestAgreesWithAllTrianglesAfterRefit) {
  Points moved = mesh_.vertices;
  for (Eigen::Index v = 0; v < moved.rows(); ++v) {
    moved(v, 2) += 0.05 * std::sin(30 * moved(v, 0));
  }
  tree_.Refit(moved);
  std::mt19937 random(4);
  for (int trial = 0; trial < 200; ++trial) {
    const Vector3d p = RandomPoint(&random, 0.15);
    EXPECT_NEAR(tree_.Closest(p, 1).distance, BruteForce(moved, p).distance, 1e-15);
  }
}

TEST_F(SurfaceTreeTest, NothingIsFoundBeyondTheDistance) {
  EXPECT_EQ(tree_.Closest(Vector3d(0, 0, 0.1), 0.04).at.triangle, -1);
  EXPECT_GE(tree_.Closest(Vector3d(0, 0, 0.1), 0.06).at.triangle, 0);
  EXPECT_EQ(tree_.ClosestToSegment(Vector3d(-1, 0, 0.1), Vector3d(1, 0, 0.1), 0.04).at.triangle,
            -1);
}

TEST_F(SurfaceTreeTest, CapsuleTouchesWhereItsAxisIsClosest) {
  const SurfaceHit hit =
      tree_.ClosestToSegment(Vector3d(-0.2, 0, 0.06), Vector3d(0.2, 0, 0.06), 0.02);
  ASSERT_GE(hit.at.triangle, 0);
  // The facets lie inside the ellipsoid by less than 0.3 mm at this resolution.
  EXPECT_NEAR(hit.distance, 0.01, 3e-4);
  EXPECT_NEAR(hit.along, 0.5, 0.05);
}

TEST_F(SurfaceTreeTest, SlantedSegmentsAgreeWithAllTriangles) {
  std::mt19937 random(5);
  int found = 0;
  for (int trial = 0; trial < 500; ++trial) {
    const Vector3d start = RandomPoint(&random, 0.2), end = RandomPoint(&random, 0.2);
    const double reach = 0.05 * random() / 4294967295.0;
    double nearest = reach, entry = 2;
    for (Eigen::Index t = 0; t < mesh_.triangles.rows(); ++t) {
      const Vector3d a = mesh_.vertices.row(mesh_.triangles(t, 0)),
                     b = mesh_.vertices.row(mesh_.triangles(t, 1)),
                     c = mesh_.vertices.row(mesh_.triangles(t, 2));
      const double distance2 = ClosestSegmentTriangle(start, end, a, b, c).squared_distance;
      nearest = std::min(nearest, std::sqrt(distance2));
      double along = 0;
      Vector3d weights;
      if (CrossesFromFront(start, end, a, b, c, &along, &weights)) entry = std::min(entry, along);
    }
    const SurfaceHit hit = tree_.ClosestToSegment(start, end, reach);
    EXPECT_EQ(hit.at.triangle >= 0, nearest < reach);
    if (nearest < reach) {
      EXPECT_EQ(hit.distance, nearest);
    }
    const SurfaceHit first = tree_.FirstEntry(start, end);
    EXPECT_EQ(first.at.triangle >= 0, entry <= 1);
    if (entry <= 1) {
      EXPECT_EQ(first.along, entry);
    }
    found += nearest < reach;
  }
  EXPECT_GT(found, 100);
}

TEST_F(SurfaceTreeTest, FirstEntryIsTheFrontHoweverFarTheStep) {
  const SurfaceHit hit = tree_.FirstEntry(Vector3d(0.01, 0.005, 1), Vector3d(0.01, 0.005, -1));
  ASSERT_GE(hit.at.triangle, 0);
  EXPECT_GT(hit.at.Position(mesh_.vertices, mesh_.triangles).z(), 0.04);
  // A motion from inside outwards enters nothing.
  EXPECT_EQ(tree_.FirstEntry(Vector3d::Zero(), Vector3d(0.01, 0.005, 1)).at.triangle, -1);
}

TEST_F(SurfaceTreeTest, NormalsPointOutwardsOnFacesEdgesAndCorners) {
  const SurfaceTopology topology(mesh_.vertices.rows(), mesh_.triangles);
  for (const Vector3d& weights :
       {Vector3d(1, 0, 0), Vector3d(0.5, 0.5, 0), Vector3d(0.2, 0.3, 0.5)}) {
    for (int t = 0; t < mesh_.triangles.rows(); t += 37) {
      const SurfacePoint at{t, weights};
      const Vector3d p = at.Position(mesh_.vertices, mesh_.triangles);
      const Vector3d exact = p.cwiseQuotient(Vector3d(0.01, 0.0049, 0.0025))
                                 .normalized();  // gradient of the ellipsoid
      // Facets of 642 vertices turn by up to 10 degrees.
      EXPECT_GT(InterpolatedNormal(mesh_.vertices, mesh_.triangles, topology, at).dot(exact), 0.98);
    }
  }
}

TEST_F(SurfaceTreeTest, NeighbourhoodIsTheNearestConnectedTriangles) {
  const SurfaceTopology topology(mesh_.vertices.rows(), mesh_.triangles);
  NeighbourhoodSearch search(mesh_.triangles, topology);
  Neighbourhood around;
  const SurfacePoint at{100, Vector3d::Constant(1.0 / 3)};
  for (int repeat = 0; repeat < 3; ++repeat) {
    search.Collect(mesh_.vertices, at, {96, 64}, &around);
    EXPECT_EQ(around.triangles[0], 100);
    EXPECT_LE(around.count, 96);
    EXPECT_GT(around.count, 60);
    std::vector<bool> used(mesh_.vertices.rows(), false);
    int vertices = 0;
    for (int i = 0; i < around.count; ++i) {
      for (int k = 0; k < 3; ++k) {
        const int v = mesh_.triangles(around.triangles[i], k);
        vertices += !used[v];
        used[v] = true;
      }
    }
    EXPECT_LE(vertices, 64);
  }
}

}  // namespace
}  // namespace hpdm
