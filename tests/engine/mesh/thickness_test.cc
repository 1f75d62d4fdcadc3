#include "engine/mesh/thickness.h"

#include <gtest/gtest.h>

#include "tests/support/mesh_shapes.h"

namespace hpdm {
namespace {

Eigen::VectorXd Thickness(const SurfaceMesh& mesh, double at_most) {
  Points normals;
  VertexNormals(mesh.vertices, mesh.triangles, &normals);
  return LocalThickness(mesh, normals, at_most);
}

TEST(LocalThickness, IsTheDiameterOfASphere) {
  const Eigen::VectorXd thickness = Thickness(MakeSphere(3, 0.05), 0.3);
  // The facets of this sphere lie up to 1 % below it.
  EXPECT_NEAR(thickness.minCoeff(), 0.1, 0.002);
  EXPECT_NEAR(thickness.maxCoeff(), 0.1, 0.002);
}

TEST(LocalThickness, IsTheWallOfAHollowSphere) {
  const SurfaceMesh hollow = Joined(MakeSphere(4, 0.05), Reversed(MakeSphere(4, 0.047)));
  const Eigen::VectorXd thickness = Thickness(hollow, 0.3);
  EXPECT_NEAR(thickness.mean(), 0.003, 0.0003);  // facets of both spheres: 0.2 mm
}

// The ball in the middle of the block covers its ends, or nearly so.
TEST(LocalThickness, IsThatOfABlocksMiddleUpToItsEdges) {
  const SurfaceMesh block = MakeBox(Vector3d::Zero(), Vector3d(0.1, 0.1, 0.1));
  const Eigen::VectorXd thickness = Thickness(block, 0.3);
  EXPECT_LE(thickness.maxCoeff(), 0.1 * (1 + 1e-9));
}

TEST(LocalThickness, FadesTowardsTheEdgeOfAWedge) {
  // Sides 1 : 4 on a base of 0.05 m: the edge is far from any ball, in its own radii.
  const SurfaceMesh wedge = MakeMesh(
      {{0, 0, 0}, {0.05, 0, 0}, {0.025, 0, 0.2}, {0, 0.2, 0}, {0.05, 0.2, 0}, {0.025, 0.2, 0.2}},
      {{0, 1, 2}, {3, 5, 4}, {0, 3, 4}, {0, 4, 1}, {1, 4, 5}, {1, 5, 2}, {2, 5, 3}, {2, 3, 0}});
  const Eigen::VectorXd thickness = Thickness(wedge, 0.3);
  EXPECT_LT(thickness[2], 0.02);
  EXPECT_LT(thickness[5], 0.02);
}

TEST(LocalThickness, ScalesWithTheBody) {
  SurfaceMesh mesh = MakeTorus(24, 0.1, 0.03);
  const Eigen::VectorXd thickness = Thickness(mesh, 0.3);
  mesh.vertices *= 1000;
  EXPECT_LT((Thickness(mesh, 300) / 1000 - thickness).norm(), 1e-9 * thickness.norm());
  EXPECT_NEAR(thickness.mean(), 0.06, 0.003);  // the tube's diameter, less its facets
}

TEST(LocalThickness, IsCappedWhereMoreDoesNotMatter) {
  EXPECT_EQ(Thickness(MakeSphere(2, 0.05), 0.04), Eigen::VectorXd::Constant(162, 0.04));
}

}  // namespace
}  // namespace hpdm
