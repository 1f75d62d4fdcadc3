#include "engine/mesh/mesh_subdivision.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "engine/base/error.h"
#include "engine/mesh/mesh_facts.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

TEST(Subdivision, SplitsEachTriangleInFourAndStaysClosed) {
  const SurfaceMesh mesh = Ellipsoid(Vector3d(0.1, 0.07, 0.05), 2);
  const SurfaceMesh fine = Subdivided(mesh, 2, "mesh");
  EXPECT_EQ(fine.triangles.rows(), 16 * mesh.triangles.rows());
  const MeshFacts facts = ComputeMeshFacts(fine);
  EXPECT_TRUE(facts.Closed());
  EXPECT_EQ(facts.components, 1);
  // The smooth surface lies inside the ellipsoid by less than its facets' height of 1.5 mm.
  const double volume = EnclosedVolume(fine.vertices, fine.triangles);
  EXPECT_NEAR(volume / EnclosedVolume(mesh.vertices, mesh.triangles), 1, 0.04);
  EXPECT_EQ(Subdivided(mesh, 0, "mesh").vertices, mesh.vertices);
}

// The limit surface of a plane is the plane: no rule may move a point out of it, and on a regular
// grid no point moves along it.
TEST(Subdivision, LeavesAFlatRegularPieceWhereItIs) {
  constexpr int kSide = 6;
  SurfaceMesh mesh;
  mesh.vertices.resize((kSide + 1) * (kSide + 1), 3);
  mesh.triangles.resize(2 * kSide * kSide, 3);
  for (int i = 0; i <= kSide; ++i) {
    for (int j = 0; j <= kSide; ++j) {
      mesh.vertices.row(i * (kSide + 1) + j) << i, j, 0.5;
      if (i == kSide || j == kSide) continue;
      const int a = i * (kSide + 1) + j, b = a + kSide + 1, t = 2 * (i * kSide + j);
      mesh.triangles.row(t) << a, b, b + 1;
      mesh.triangles.row(t + 1) << a, b + 1, a + 1;
    }
  }
  mesh.texture_coordinates.resize(3 * mesh.triangles.rows(), 2);
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      mesh.texture_coordinates.row(3 * t + k) =
          mesh.vertices.row(mesh.triangles(t, k)).head<2>() / kSide;
    }
  }
  const SurfaceMesh fine = Subdivided(mesh, 1, "mesh");
  EXPECT_EQ(fine.vertices.col(2).minCoeff(), 0.5);
  EXPECT_EQ(fine.vertices.col(2).maxCoeff(), 0.5);
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    const Eigen::RowVector3d p = mesh.vertices.row(v);
    const bool inside = p.x() > 0 && p.x() < kSide && p.y() > 0 && p.y() < kSide;
    const bool corner = (p.x() == 0 || p.x() == kSide) && (p.y() == 0 || p.y() == kSide);
    // Sums of six neighbours with weights of sixteenths: a rounding or two.
    if (inside) {
      EXPECT_LT((fine.vertices.row(v) - p).norm(), 1e-14);
    }
    if (!inside && !corner) {
      EXPECT_LT(std::min({p.x(), p.y(), kSide - p.x(), kSide - p.y()}), 1e-14);
    }
  }
  // The texture stays at its place.
  for (Eigen::Index t = 0; t < fine.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const Eigen::RowVector2d at = fine.vertices.row(fine.triangles(t, k)).head<2>() / kSide;
      if ((at.array() < 0.2).any() || (at.array() > 0.8).any()) continue;  // rounded corners
      EXPECT_LT((fine.texture_coordinates.row(3 * t + k) - at).norm(), 1e-14);
    }
  }
}

TEST(Subdivision, RefusesMoreTrianglesThanAnyMachineDraws) {
  const SurfaceMesh mesh = Ellipsoid(Vector3d::Ones(), 3);
  EXPECT_THROW(Subdivided(mesh, 6, "mesh"), InputError);  // 1,280 x 4,096
}

}  // namespace
}  // namespace hpdm
