#include "engine/mesh/surface_mesh.h"

#include <gtest/gtest.h>

namespace hpdm {
namespace {

SurfaceMesh Tetrahedron() {
  SurfaceMesh mesh;
  mesh.vertices.resize(4, 3);
  mesh.vertices << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  mesh.triangles.resize(4, 3);
  mesh.triangles << 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3;
  return mesh;
}

TEST(SurfaceMesh, VolumeIsExactAndIndependentOfTheOrigin) {
  SurfaceMesh mesh = Tetrahedron();
  EXPECT_DOUBLE_EQ(EnclosedVolume(mesh.vertices, mesh.triangles), 1.0 / 6);
  mesh.vertices.rowwise() += Eigen::RowVector3d(100, -50, 25);
  // Round-off of coordinates of size 100 m: 1e-14 relative.
  EXPECT_NEAR(EnclosedVolume(mesh.vertices, mesh.triangles), 1.0 / 6, 1e-12);
}

TEST(SurfaceMesh, NormalsPointOutwardsAndAreUnit) {
  const SurfaceMesh mesh = Tetrahedron();
  Points normals;
  VertexNormals(mesh.vertices, mesh.triangles, &normals);
  const Eigen::RowVector3d centre = mesh.vertices.colwise().mean();
  for (int v = 0; v < 4; ++v) {
    EXPECT_NEAR(normals.row(v).norm(), 1, 1e-15);
    EXPECT_GT(normals.row(v).dot(mesh.vertices.row(v) - centre), 0);
  }
}

}  // namespace
}  // namespace hpdm
