#include "render/tissue/mesh_renderer.h"

#include <gtest/gtest.h>

#include <numbers>

#include "render/instrument/capsule_mesh.h"

namespace hpdm {
namespace {

SurfaceMesh Cube() {
  SurfaceMesh mesh;
  mesh.vertices.resize(8, 3);
  for (int v = 0; v < 8; ++v) mesh.vertices.row(v) << (v & 1), (v >> 1 & 1), (v >> 2 & 1);
  mesh.triangles.resize(12, 3);
  mesh.triangles << 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6,
      0, 6, 2, 1, 3, 7, 1, 7, 5;
  return mesh;
}

TEST(MeshRenderer, SinglePrecisionNormalsAreTheEnginesNormals) {
  const SurfaceMesh mesh = CapsuleMesh(0.004, 0.0025, 0.3);
  Points expected;
  VertexNormals(mesh.vertices, mesh.triangles, &expected);
  PointsF normals;
  VertexNormalsF(mesh.vertices.cast<float>(), mesh.triangles, &normals);
  // Edges of 0.3 mm at positions of 0.3 m keep four digits in single precision.
  EXPECT_LT((normals.cast<double>() - expected).cwiseAbs().maxCoeff(), 1e-3);
}

TEST(MeshRenderer, ClosedMeansEveryEdgeTwiceAndOutwards) {
  SurfaceMesh mesh = Cube();
  EXPECT_TRUE(IsClosed(mesh));
  SurfaceMesh open = mesh;
  open.triangles.conservativeResize(11, 3);
  EXPECT_FALSE(IsClosed(open));
  SurfaceMesh one_flipped = mesh;
  one_flipped.triangles.row(3).reverseInPlace();
  EXPECT_FALSE(IsClosed(one_flipped));
  SurfaceMesh inside_out = mesh;
  inside_out.triangles = mesh.triangles.rowwise().reverse().eval();
  EXPECT_FALSE(IsClosed(inside_out));
}

TEST(MeshRenderer, CutsKeepTheFacesOfACubeFlat) {
  const CreasedMesh creased = CutCreases(Cube(), std::numbers::pi / 4);
  EXPECT_TRUE(creased.closed);
  ASSERT_EQ(creased.normals.rows(), 36);
  for (int corner = 0; corner < 36; ++corner) {
    // A face's normal is along one axis, so exactly one component is +-1.
    EXPECT_EQ(creased.normals.row(corner).cwiseAbs().maxCoeff(), 1);
    EXPECT_EQ(creased.normals.row(corner).cwiseAbs().sum(), 1);
  }
}

TEST(MeshRenderer, SeamsRepeatOnlyTheVerticesWhoseCornersDiffer) {
  SurfaceMesh mesh = Cube();
  EXPECT_TRUE(CutSeams(mesh).copies.empty());
  // Flat from above: one coordinate a vertex, and no seam.
  mesh.texture_coordinates.resize(36, 2);
  for (int c = 0; c < 36; ++c) {
    mesh.texture_coordinates.row(c) = mesh.vertices.row(mesh.triangles(c / 3, c % 3)).leftCols<2>();
  }
  EXPECT_TRUE(CutSeams(mesh).copies.empty());
  // The top (triangles 2 and 3, vertices 4 to 7) elsewhere in the atlas: its four vertices twice.
  mesh.texture_coordinates.middleRows(6, 6).array() += 2.0;
  const SeamedMesh seamed = CutSeams(mesh);
  ASSERT_EQ(seamed.copies.size(), 4u);
  ASSERT_EQ(seamed.texture_coordinates.rows(), 12);
  for (int c = 0; c < 36; ++c) {
    const int drawn = seamed.triangles(c / 3, c % 3);
    EXPECT_EQ(drawn < 8 ? drawn : seamed.copies[drawn - 8], mesh.triangles(c / 3, c % 3));
    EXPECT_EQ(seamed.texture_coordinates.row(drawn).cast<double>(),
              mesh.texture_coordinates.row(c));
  }
}

TEST(MeshRenderer, ACapsuleIsClosedAndOnItsRadii) {
  for (const double tip : {0.002, 0.0025, 0.005}) {
    const SurfaceMesh mesh = CapsuleMesh(tip, 0.0025, 0.3);
    EXPECT_TRUE(IsClosed(mesh)) << tip;
    EXPECT_DOUBLE_EQ(mesh.vertices.col(2).minCoeff(), -tip);
    EXPECT_DOUBLE_EQ(mesh.vertices.col(2).maxCoeff(), 0.3);
    for (int v = 0; v < mesh.vertices.rows(); ++v) {
      const Vector3d p = mesh.vertices.row(v);
      // Below the equator on the sphere; from where the shaft begins, on it.
      if (p.z() <= 0) {
        EXPECT_NEAR(p.norm(), tip, 1e-15);
      }
      if (p.z() > 0.01 && p.z() < 0.29) {
        EXPECT_NEAR(p.head<2>().norm(), 0.0025, 1e-15);
      }
    }
  }
}

}  // namespace
}  // namespace hpdm
