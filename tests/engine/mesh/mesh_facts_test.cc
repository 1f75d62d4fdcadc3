#include "engine/mesh/mesh_facts.h"

#include <gtest/gtest.h>

#include "tests/support/mesh_shapes.h"

namespace hpdm {
namespace {

TEST(MeshFacts, ACubeIsClosedAndMeasuredExactly) {
  const MeshFacts facts = ComputeMeshFacts(MakeBox(Vector3d(1, 2, 3), Vector3d(2, 4, 6)));
  EXPECT_EQ(facts.vertices, 8);
  EXPECT_EQ(facts.triangles, 12);
  EXPECT_TRUE(facts.Closed());
  EXPECT_EQ(facts.inconsistent_edges, 0);
  EXPECT_EQ(facts.components, 1);
  EXPECT_EQ(facts.euler_characteristic, 2);
  EXPECT_EQ(facts.genus, 0);
  // Round-off of coordinates of size 6.
  EXPECT_NEAR(facts.volume_m3, 6, 1e-13);
  EXPECT_NEAR(facts.area_m2, 22, 1e-13);
  EXPECT_EQ(facts.min_edge, 1);
  EXPECT_EQ(facts.box_min, Vector3d(1, 2, 3));
  EXPECT_EQ(facts.box_max, Vector3d(2, 4, 6));
}

TEST(MeshFacts, ATorusHasGenusOne) {
  const MeshFacts facts = ComputeMeshFacts(MakeTorus(12, 1, 0.3));
  EXPECT_TRUE(facts.Closed());
  EXPECT_EQ(facts.euler_characteristic, 0);
  EXPECT_EQ(facts.genus, 1);
}

TEST(MeshFacts, TheGenusOfSeveralComponentsAddsUp) {
  const MeshFacts facts = ComputeMeshFacts(Joined(MakeTorus(12, 1, 0.3), MakeTorus(12, 1, 0.2)));
  EXPECT_EQ(facts.components, 2);
  EXPECT_EQ(facts.genus, 2);
}

TEST(MeshFacts, AMissingTriangleLeavesThreeBoundaryEdges) {
  const MeshFacts facts = ComputeMeshFacts(Without(MakeSphere(1), 5, 1));
  EXPECT_EQ(facts.boundary_edges, 3);
  EXPECT_FALSE(facts.Closed());
  EXPECT_FALSE(facts.genus.has_value());
}

TEST(MeshFacts, ATurnedTriangleHasThreeInconsistentEdges) {
  SurfaceMesh sphere = MakeSphere(1);
  std::swap(sphere.triangles(7, 0), sphere.triangles(7, 1));
  EXPECT_EQ(ComputeMeshFacts(sphere).inconsistent_edges, 3);
}

TEST(MeshFacts, AFinOnAClosedSurfaceIsNonManifold) {
  SurfaceMesh box = MakeBox(Vector3d::Zero(), Vector3d::Ones());
  box.vertices.conservativeResize(9, 3);
  box.vertices.row(8) << 2, 2, 2;
  box.triangles.conservativeResize(13, 3);
  box.triangles.row(12) << 3, 7, 8;  // on the edge between two faces
  const MeshFacts facts = ComputeMeshFacts(box);
  EXPECT_EQ(facts.nonmanifold_edges, 1);
  EXPECT_EQ(facts.boundary_edges, 2);
}

TEST(MeshFacts, NeedlesAreDegenerateAtEveryScale) {
  for (const double scale : {1e-6, 1.0, 1e6}) {
    SurfaceMesh mesh = MakeMesh({{0, 0, 0}, {1, 0, 0}, {0.5, 1e-8, 0}, {0.5, 0.1, 0}},
                                {{0, 1, 2}, {0, 1, 3}, {0, 0, 1}});
    mesh.vertices *= scale;
    EXPECT_EQ(ComputeMeshFacts(mesh).degenerate_triangles, 2);
  }
}

TEST(MeshFacts, AnEmptyMeshHasNoFacts) {
  const MeshFacts facts = ComputeMeshFacts(SurfaceMesh());
  EXPECT_EQ(facts.vertices, 0);
  EXPECT_FALSE(facts.Closed());
}

}  // namespace
}  // namespace hpdm
