#include "engine/mesh/winding_number.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "tests/support/mesh_shapes.h"

namespace hpdm {
namespace {

/// Returns points in the cube [-half, half]^3.
std::vector<Vector3d> RandomPoints(int count, double half, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> coordinate(-half, half);
  std::vector<Vector3d> points;
  for (int i = 0; i < count; ++i) {
    const double x = coordinate(random), y = coordinate(random), z = coordinate(random);
    points.emplace_back(x, y, z);
  }
  return points;
}

double WorstError(const SurfaceMesh& mesh, double opening) {
  const WindingNumber winding(mesh, opening);
  double worst = 0;
  for (const Vector3d& p : RandomPoints(300, 1.5, 7)) {
    worst = std::max(worst, std::abs(winding.At(p) - ExactWindingNumber(mesh, p)));
  }
  return worst;
}

TEST(WindingNumber, IsOneInsideAndZeroOutsideAClosedSurface) {
  const SurfaceMesh sphere = MakeSphere(3);
  const WindingNumber winding(sphere);
  for (const Vector3d& p : RandomPoints(500, 1.5, 1)) {
    // The polyhedron's faces lie between radius 0.98 and 1.
    if (p.norm() > 0.98 && p.norm() < 1) continue;
    const double expected = p.norm() < 0.98 ? 1 : 0;
    // The exact sum is exact but for rounding; the tree's bound is the next test's.
    EXPECT_NEAR(ExactWindingNumber(sphere, p), expected, 1e-12);
    EXPECT_NEAR(winding.At(p), expected, 1e-2);
  }
}

TEST(WindingNumber, StaysWithinAHundredthOfTheExactSum) {
  // The second-order expansion leaves a relative error of about opening^-3 of clusters whose own
  // share is a few hundredths.
  EXPECT_LT(WorstError(MakeSphere(4), 2), 1e-2);
  EXPECT_LT(WorstError(MakeTorus(40, 1, 0.3), 2), 1e-2);
  EXPECT_LT(WorstError(Without(MakeSphere(4), 0, 700), 2), 1e-2);
}

TEST(WindingNumber, ConvergesAtThirdOrderInTheOpening) {
  const SurfaceMesh torus = MakeTorus(40, 1, 0.3);
  // Doubling the opening divides the first omitted term by 8; errors of clusters cancel further.
  EXPECT_LT(WorstError(torus, 4), WorstError(torus, 2) / 6);
  EXPECT_LT(WorstError(torus, 1e6), 1e-12);  // every triangle exact: rounding only
}

TEST(WindingNumber, DoesNotDependOnWhereTheSurfaceIsCloseBy) {
  const SurfaceMesh box = MakeBox(Vector3d(-1, -1, -1), Vector3d(1, 1, 1));
  const WindingNumber winding(box);
  for (const double depth : {1e-3, 1e-6, 1e-9}) {
    // 12 triangles are one leaf and its sibling: nearly all terms are exact.
    EXPECT_NEAR(winding.At({0.3, 0.2, 1 - depth}), 1, 1e-2);
    EXPECT_NEAR(winding.At({0.3, 0.2, 1 + depth}), 0, 1e-2);
  }
}

TEST(WindingNumber, LosesOnlyTheSolidAngleOfAGap) {
  // The cap around +z up to the polar angle t spans (1 - cos t) / 2 of the full solid angle.
  const SurfaceMesh sphere = MakeSphere(4);
  SurfaceMesh open = sphere;
  Eigen::Index kept = 0;
  const double cut = 0.8;
  for (Eigen::Index t = 0; t < sphere.triangles.rows(); ++t) {
    double top = -1;
    for (int c = 0; c < 3; ++c) top = std::max(top, sphere.vertices(sphere.triangles(t, c), 2));
    if (top <= cut) open.triangles.row(kept++) = sphere.triangles.row(t);
  }
  open.triangles.conservativeResize(kept, 3);
  // The rim is ragged by one triangle, 0.07 high: 0.035 of the sphere; plus the tree's 0.01.
  EXPECT_NEAR(WindingNumber(open).At(Vector3d::Zero()), 1 - (1 - cut) / 2, 0.045);
  EXPECT_GT(WindingNumber(open).At({0, 0, 0.6}), 0.5);
  EXPECT_LT(WindingNumber(open).At({0, 0, 1.4}), 0.5);
  EXPECT_LT(WindingNumber(open).At({0, 0, -1.1}), 0.1);
}

TEST(WindingNumber, CountsOverlapsAndCavities) {
  const SurfaceMesh outer = MakeSphere(2), inner = MakeSphere(2, 0.5);
  EXPECT_NEAR(WindingNumber(Joined(outer, inner)).At(Vector3d::Zero()), 2, 2e-2);
  EXPECT_NEAR(WindingNumber(Joined(outer, Reversed(inner))).At(Vector3d::Zero()), 0, 2e-2);
  EXPECT_NEAR(WindingNumber(Joined(outer, Reversed(inner))).At({0, 0, 0.7}), 1, 2e-2);
  EXPECT_NEAR(WindingNumber(Reversed(outer)).At(Vector3d::Zero()), -1, 1e-2);
}

TEST(WindingNumber, IsFiniteOnTheSurfaceAndForDegenerateTriangles) {
  SurfaceMesh box = MakeBox(Vector3d::Zero(), Vector3d::Ones());
  box.triangles.conservativeResize(13, 3);
  box.triangles.row(12) << 3, 3, 3;
  const WindingNumber winding(box);
  for (Eigen::Index v = 0; v < 8; ++v) {
    EXPECT_TRUE(std::isfinite(winding.At(box.vertices.row(v))));
  }
  EXPECT_TRUE(std::isfinite(winding.At({0.5, 0.5, 0})));
  EXPECT_NEAR(winding.At({0.5, 0.5, 0.5}), 1, 1e-2);
  EXPECT_EQ(WindingNumber(SurfaceMesh()).At(Vector3d::Zero()), 0);
}

}  // namespace
}  // namespace hpdm
