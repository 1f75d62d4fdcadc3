#include "engine/mesh/mesh_repair.h"

#include <gtest/gtest.h>

#include <random>

#include "engine/mesh/mesh_facts.h"
#include "tests/support/mesh_shapes.h"

namespace hpdm {
namespace {

/// Returns the mesh with three separate vertices for each triangle, each moved by up to `noise`.
SurfaceMesh Soup(const SurfaceMesh& mesh, double noise) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> offset(-noise, noise);
  SurfaceMesh soup;
  soup.vertices.resize(3 * mesh.triangles.rows(), 3);
  soup.triangles.resize(mesh.triangles.rows(), 3);
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    for (Eigen::Index c = 0; c < 3; ++c) {
      const Eigen::Index v = 3 * t + c;
      soup.triangles(t, c) = static_cast<int>(v);
      for (int d = 0; d < 3; ++d) {
        soup.vertices(v, d) = mesh.vertices(mesh.triangles(t, c), d) + offset(random);
      }
    }
  }
  return soup;
}

TEST(MeshRepair, LeavesASoundMeshAlone) {
  const SurfaceMesh sphere = MakeSphere(2);
  SurfaceMesh mended = sphere;
  EXPECT_TRUE(RepairMesh(&mended).List().empty());
  EXPECT_EQ(mended.vertices, sphere.vertices);
  EXPECT_EQ(mended.triangles, sphere.triangles);
}

TEST(MeshRepair, WeldsASoupIntoItsSurfaceAtEveryScale) {
  for (const double scale : {1e-3, 1.0, 1e4}) {
    // A fifth of the tolerance, 1e-6 of the diagonal 2 sqrt(3).
    SurfaceMesh soup = Soup(MakeSphere(3), 0.7e-6);
    soup.vertices *= scale;
    const MeshRepairs repairs = RepairMesh(&soup);
    const MeshFacts facts = ComputeMeshFacts(soup);
    EXPECT_EQ(facts.vertices, 642);
    EXPECT_EQ(repairs.welded_vertices, 3 * 1280 - 642);
    EXPECT_TRUE(facts.Closed());
    EXPECT_EQ(facts.components, 1);
  }
}

TEST(MeshRepair, DropsDegenerateAndDuplicateTrianglesAndUnusedVertices) {
  SurfaceMesh box = MakeBox(Vector3d::Zero(), Vector3d::Ones());
  box.vertices.conservativeResize(10, 3);
  box.vertices.row(8) << 0.2, 0.3, 0.4;
  box.vertices.row(9) << 1, 1, 1;  // as vertex 7
  box.triangles.conservativeResize(16, 3);
  box.triangles.row(12) << 3, 2, 0;  // turned round
  box.triangles.row(13) << 2, 3, 0;  // rotated
  box.triangles.row(14) << 1, 1, 4;
  box.triangles.row(15) << 7, 9, 2;  // degenerate once welded
  const MeshRepairs repairs = RepairMesh(&box);
  EXPECT_EQ(repairs.welded_vertices, 1);
  EXPECT_EQ(repairs.degenerate_triangles, 2);
  EXPECT_EQ(repairs.duplicate_triangles, 2);
  EXPECT_EQ(repairs.unreferenced_vertices, 1);
  EXPECT_EQ(box.vertices.rows(), 8);
  EXPECT_TRUE(ComputeMeshFacts(box).Closed());
}

TEST(MeshRepair, TurnsRandomlyTurnedTrianglesOutwards) {
  SurfaceMesh sphere = MakeSphere(3);
  std::mt19937 random(5);
  int turned = 0;
  for (Eigen::Index t = 0; t < sphere.triangles.rows(); ++t) {
    if (random() % 2 == 0) continue;
    std::swap(sphere.triangles(t, 0), sphere.triangles(t, 1));
    ++turned;
  }
  EXPECT_EQ(RepairMesh(&sphere).reoriented_triangles, turned);
  const MeshFacts facts = ComputeMeshFacts(sphere);
  EXPECT_EQ(facts.inconsistent_edges, 0);
  EXPECT_GT(facts.volume_m3, 4);
}

TEST(MeshRepair, CavitiesFaceInwardsAndSolidsInsideThemOutwards) {
  // Three nested spheres, each given the wrong way round: tissue, cavity, tissue.
  SurfaceMesh nested =
      Joined(Joined(Reversed(MakeSphere(2, 3)), MakeSphere(2, 2)), Reversed(MakeSphere(2, 1)));
  const double unit = EnclosedVolume(MakeSphere(2).vertices, MakeSphere(2).triangles);
  EXPECT_EQ(RepairMesh(&nested).reoriented_triangles, 3 * 320);
  // Round-off.
  EXPECT_NEAR(EnclosedVolume(nested.vertices, nested.triangles), unit * (27 - 8 + 1), 1e-11);
}

TEST(MeshRepair, SolidsSideBySideOrCrossingAllFaceOutwards) {
  SurfaceMesh shifted = MakeSphere(2);
  shifted.vertices.col(0).array() += 1;  // crosses the first sphere
  SurfaceMesh far = Reversed(MakeSphere(2, 0.1));
  far.vertices.col(0).array() += 9;
  SurfaceMesh all = Joined(Joined(MakeSphere(2), shifted), far);
  EXPECT_EQ(RepairMesh(&all).reoriented_triangles, 320);
  EXPECT_GT(EnclosedVolume(all.vertices, all.triangles),
            2 * EnclosedVolume(shifted.vertices, shifted.triangles));
}

TEST(MeshRepair, AnOpenBowlFacesWhereItBulgesAndAFlatSheetWhereMostOfItFaced) {
  SurfaceMesh bowl = Reversed(Without(MakeSphere(3), 0, 200));
  RepairMesh(&bowl);
  EXPECT_GT(EnclosedVolume(bowl.vertices, bowl.triangles), 0);

  SurfaceMesh sheet = MakeMesh({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {2, 0, 0}},
                               {{0, 2, 1}, {0, 3, 2}, {1, 4, 2}});
  EXPECT_EQ(RepairMesh(&sheet).reoriented_triangles, 1);
  EXPECT_EQ(ComputeMeshFacts(sheet).inconsistent_edges, 0);
  EXPECT_EQ(sheet.triangles(0, 1), 2);  // the two that faced down stay
}

TEST(MeshRepair, AMoebiusStripKeepsOneInconsistentEdge) {
  std::vector<Vector3d> vertices;
  std::vector<std::array<int, 3>> triangles;
  const int n = 12;
  for (int i = 0; i < n; ++i) {
    const double u = 2 * std::numbers::pi * i / n;
    const Vector3d out(std::cos(u), std::sin(u), 0);
    const Vector3d half = std::cos(u / 2) * out + std::sin(u / 2) * Vector3d::UnitZ();
    vertices.push_back(out + 0.3 * half);
    vertices.push_back(out - 0.3 * half);
    const int a = 2 * i, b = a + 1, c = i + 1 < n ? a + 2 : 1, d = i + 1 < n ? a + 3 : 0;
    triangles.insert(triangles.end(), {{a, c, b}, {b, c, d}});
  }
  SurfaceMesh strip = MakeMesh(vertices, triangles);
  RepairMesh(&strip);
  EXPECT_EQ(ComputeMeshFacts(strip).inconsistent_edges, 1);  // one-sided: it cannot be none
}

TEST(MeshRepair, CornersKeepTheirTextureCoordinatesThroughEveryRepair) {
  // A soup of a box, some triangles turned round, with a duplicate and a degenerate triangle in the
  // middle. Each corner's texture coordinates are made of its place and its triangle's normal.
  SurfaceMesh soup = Soup(MakeBox(Vector3d::Zero(), Vector3d::Ones()), 0.7e-7);
  soup.triangles.conservativeResize(14, 3);
  soup.triangles.row(12) = soup.triangles.row(5);
  soup.triangles.row(13) = soup.triangles.row(11);
  soup.triangles.row(11) = soup.triangles.row(5);
  soup.triangles.row(12) << 0, 0, 1;
  for (const int t : {2, 3, 7}) std::swap(soup.triangles(t, 0), soup.triangles(t, 1));
  const auto place = [&](int v, int t) {
    const Vector3d p = soup.vertices.row(v).array().round().transpose();
    const Vector3d side = soup.vertices.row(soup.triangles(t, 0)) +
                          soup.vertices.row(soup.triangles(t, 1)) +
                          soup.vertices.row(soup.triangles(t, 2));
    return Eigen::RowVector2d(p.x() + 2 * p.y() + 4 * p.z(), (side.array() * 2 / 3).round().sum());
  };
  const auto expected = [&] {
    TextureCoordinates uv(3 * soup.triangles.rows(), 2);
    for (int t = 0; t < static_cast<int>(soup.triangles.rows()); ++t) {
      for (int c = 0; c < 3; ++c) uv.row(3 * t + c) = place(soup.triangles(t, c), t);
    }
    return uv;
  };
  soup.texture_coordinates = expected();
  JoinIdenticalVertices(&soup);
  const MeshRepairs repairs = RepairMesh(&soup);
  EXPECT_EQ(repairs.degenerate_triangles, 1);
  EXPECT_EQ(repairs.duplicate_triangles, 1);
  EXPECT_EQ(repairs.reoriented_triangles, 3);
  EXPECT_EQ(soup.vertices.rows(), 8);
  EXPECT_TRUE(ComputeMeshFacts(soup).Closed());
  EXPECT_EQ(soup.texture_coordinates, expected());
}

}  // namespace
}  // namespace hpdm
