#include <cmath>
#include <numbers>

#include "tests/bad_input/meshes/mesh_faults.h"

namespace hpdm {
namespace {

using Index = Eigen::Index;

void AddTriangle(const std::array<int, 3>& triangle, SurfaceMesh* mesh) {
  mesh->triangles.conservativeResize(mesh->triangles.rows() + 1, 3);
  mesh->triangles.bottomRows<1>() << triangle[0], triangle[1], triangle[2];
}

int AddVertex(const Vector3d& vertex, SurfaceMesh* mesh) {
  mesh->vertices.conservativeResize(mesh->vertices.rows() + 1, 3);
  mesh->vertices.bottomRows<1>() = vertex.transpose();
  return static_cast<int>(mesh->vertices.rows()) - 1;
}

Index DrawTriangle(const SurfaceMesh& mesh, MeshFaults* faults) {
  return static_cast<Index>(faults->Draw(static_cast<std::size_t>(mesh.triangles.rows())));
}

std::array<int, 3> Corners(const SurfaceMesh& mesh, Index t) {
  return {mesh.triangles(t, 0), mesh.triangles(t, 1), mesh.triangles(t, 2)};
}

SurfaceMesh Moved(SurfaceMesh mesh, const Vector3d& by) {
  mesh.vertices.rowwise() += by.transpose();
  return mesh;
}

SurfaceMesh ScaledBy(SurfaceMesh mesh, double factor) {
  mesh.vertices *= factor;
  return mesh;
}

/// Gives every triangle its own three vertices, each moved by up to `noise` along each axis.
SurfaceMesh Apart(const SurfaceMesh& mesh, double noise, MeshFaults* faults) {
  SurfaceMesh soup;
  for (Index t = 0; t < mesh.triangles.rows(); ++t) {
    std::array<int, 3> corners;
    for (std::size_t c = 0; c < 3; ++c) {
      const Vector3d p = mesh.vertices.row(mesh.triangles(t, static_cast<Index>(c)));
      corners[c] = AddVertex(p + noise * faults->DrawPoint(), &soup);
    }
    AddTriangle(corners, &soup);
  }
  return soup;
}

/// Triangles that are flipped, duplicated or damaged.
void AddTriangleFaults(MeshFaults* faults) {
  const SurfaceMesh body = SoundBody();
  SurfaceMesh mesh = body;
  mesh.triangles.row(DrawTriangle(mesh, faults)).reverseInPlace();
  faults->Add("a_triangle_turned_round.ply", mesh);

  mesh = body;
  for (Index t = 0; t < mesh.triangles.rows(); ++t) {
    if (faults->Draw(2) == 1) mesh.triangles.row(t).reverseInPlace();
  }
  faults->Add("triangles_turned_at_random.obj", mesh);
  faults->Add("inside_out.stl", Reversed(body));

  mesh = body;
  AddTriangle(Corners(mesh, DrawTriangle(mesh, faults)), &mesh);
  faults->Add("a_triangle_twice.obj", mesh);
  mesh.triangles.bottomRows<1>().reverseInPlace();
  faults->Add("a_triangle_twice_both_ways_round.ply", mesh);
  faults->Add("every_triangle_twice.stl", Joined(body, body));
  faults->Add("every_triangle_twice_both_ways_round.ply", Joined(body, Reversed(body)));

  mesh = body;
  const Index struck = DrawTriangle(mesh, faults);
  AddTriangle({mesh.triangles(struck, 0), mesh.triangles(struck, 0), mesh.triangles(struck, 1)},
              &mesh);
  faults->Add("a_corner_twice_in_a_triangle.obj", mesh);

  // A vertex in the middle of an edge, on one side of it only.
  mesh = body;
  const Index split = DrawTriangle(mesh, faults);
  const std::array<int, 3> corners = Corners(mesh, split);
  const int middle = AddVertex(
      (mesh.vertices.row(corners[0]) + mesh.vertices.row(corners[1])).transpose() / 2, &mesh);
  mesh.triangles.row(split) << corners[0], middle, corners[2];
  AddTriangle({middle, corners[1], corners[2]}, &mesh);
  faults->Add("a_vertex_on_an_edge_of_one_side.obj", mesh);
  AddTriangle({corners[0], corners[1], middle}, &mesh);
  faults->Add("a_needle_closes_a_crack.obj", mesh);

  mesh = SurfaceMesh();
  for (int i = 0; i < 180; ++i) {
    AddVertex(faults->DrawPoint() / 20, &mesh);
    if (i % 3 == 2) AddTriangle({i - 2, i - 1, i}, &mesh);
  }
  faults->Add("triangles_at_random.stl", mesh);
}

/// Holes, and vertices with no triangle or too many triangles.
void AddTopologyFaults(MeshFaults* faults) {
  const SurfaceMesh body = SoundBody();
  SurfaceMesh mesh = Without(body, DrawTriangle(body, faults), 1);
  faults->Add("a_triangle_missing.obj", mesh);
  faults->Add("half_missing.ply", Without(body, 0, 40));
  faults->Add("a_single_triangle.stl", Without(body, 1, 79));

  mesh = body;
  for (int i = 0; i < 5; ++i) AddVertex(0.01 * Vector3d(i, -i, 1), &mesh);
  faults->Add("unused_vertices.ply", mesh);
  mesh = body;
  AddVertex(Vector3d(1e9, -1e9, 1e9), &mesh);
  faults->Add("an_unused_vertex_far_away.obj", mesh);

  faults->Add("corners_apart_by_rounding.stl", Apart(body, 1e-8, faults));
  faults->Add("corners_apart_by_a_hundredth_of_an_edge.stl", Apart(body, 3e-4, faults));

  mesh = body;
  const std::array<int, 3> at = Corners(mesh, DrawTriangle(mesh, faults));
  AddTriangle({at[0], at[1], AddVertex(2 * mesh.vertices.row(at[0]).transpose(), &mesh)}, &mesh);
  faults->Add("a_fin.obj", mesh);

  const SurfaceMesh box = MakeBox(Vector3d::Zero(), Vector3d::Constant(0.1));
  faults->Add("two_boxes_with_one_edge.ply", Joined(box, Moved(box, Vector3d(0.1, 0.1, 0))));
  faults->Add("two_boxes_with_one_corner.stl", Joined(box, Moved(box, Vector3d(0.1, 0.1, 0.1))));
  faults->Add("two_boxes_with_one_side.obj", Joined(box, Moved(box, Vector3d(0.1, 0, 0))));

  // A Moebius band.
  SurfaceMesh strip;
  const int n = 12;
  for (int i = 0; i < n; ++i) {
    const double u = 2 * std::numbers::pi * i / n;
    const Vector3d out(std::cos(u), std::sin(u), 0);
    const Vector3d half = std::cos(u / 2) * out + std::sin(u / 2) * Vector3d::UnitZ();
    AddVertex(0.05 * (out + 0.3 * half), &strip);
    const int b = AddVertex(0.05 * (out - 0.3 * half), &strip), a = b - 1;
    const int c = i + 1 < n ? a + 2 : 1, d = i + 1 < n ? a + 3 : 0;
    AddTriangle({a, c, b}, &strip);
    AddTriangle({b, c, d}, &strip);
  }
  faults->Add("a_one_sided_band.obj", strip);

  // A closed cone whose apex and centre have 1,500 triangles each.
  SurfaceMesh cone;
  const int apex = AddVertex(Vector3d(0, 0, 0.05), &cone),
            centre = AddVertex(Vector3d::Zero(), &cone);
  for (int i = 0; i < 1500; ++i) {
    const double u = 2 * std::numbers::pi * i / 1500;
    const int here = AddVertex(0.05 * Vector3d(std::cos(u), std::sin(u), 0), &cone);
    const int next = i + 1 < 1500 ? here + 1 : 2;
    AddTriangle({here, next, apex}, &cone);
    AddTriangle({next, here, centre}, &cone);
  }
  faults->Add("a_vertex_of_fifteen_hundred_triangles.ply", cone);
}

/// Parts that cross, contain or dwarf each other.
void AddPartFaults(MeshFaults* faults) {
  const SurfaceMesh body = SoundBody();
  faults->Add("two_spheres_cross.ply", Joined(body, Moved(body, Vector3d(0.04, 0.01, 0))));
  faults->Add("a_cavity_that_faces_outwards.stl", Joined(body, ScaledBy(body, 0.6)));

  // An hourglass: the upper half of a box is turned by half a turn, so that its sides cross.
  SurfaceMesh hourglass = MakeBox(Vector3d::Constant(-0.05), Vector3d::Constant(0.05));
  for (int v = 4; v < 8; ++v) hourglass.vertices.row(v).head<2>() *= -1;
  faults->Add("sides_cross.obj", hourglass);

  SurfaceMesh grain = MakeBox(Vector3d::Zero(), Vector3d::Constant(1e-3)), grains;
  grains.vertices.resize(8 * 2197, 3);
  grains.triangles.resize(12 * 2197, 3);
  for (int i = 0; i < 2197; ++i) {
    const Vector3d at = 2e-3 * Vector3d(i % 13, i / 13 % 13, i / 169);
    grains.vertices.middleRows<8>(8 * i) = Moved(grain, at).vertices;
    grains.triangles.middleRows<12>(12 * i) = grain.triangles.array() + 8 * i;
  }
  faults->Add("two_thousand_parts.ply", grains);

  SurfaceMesh shells = body;
  for (int i = 1; i < 40; ++i) shells = Joined(shells, ScaledBy(body, 1 - i / 40.0));
  faults->Add("forty_spheres_in_each_other.ply", shells);

  SurfaceMesh mesh = body;
  const int corner = AddVertex(Vector3d(1e5, 0, 0), &mesh),
            other = AddVertex(Vector3d(0, 1e5, 0), &mesh);
  AddTriangle({corner, other, AddVertex(Vector3d(0, 0, 1e5), &mesh)}, &mesh);
  faults->Add("a_giant_triangle_beside.obj", mesh);
  faults->Add("a_body_a_kilometre_away.stl", Joined(body, Moved(body, Vector3d(1e3, 0, 0))));
}

/// Bodies without a volume, or with an absurd size or place.
void AddSizeFaults(MeshFaults* faults) {
  const SurfaceMesh body = SoundBody();
  SurfaceMesh mesh = body;
  mesh.vertices.col(2).setZero();
  faults->Add("pressed_flat.obj", mesh);
  mesh.vertices.col(1).setZero();
  faults->Add("all_vertices_on_a_line.ply", mesh);
  mesh.vertices.setConstant(0.25);
  faults->Add("all_vertices_at_one_place.stl", mesh);

  mesh = SurfaceMesh();
  for (int i = 0; i < 16; ++i) AddVertex(0.02 * Vector3d(i % 4, i / 4, 0), &mesh);
  for (int i = 0; i < 11; ++i) {
    if (i % 4 == 3) continue;
    AddTriangle({i, i + 1, i + 5}, &mesh);
    AddTriangle({i, i + 5, i + 4}, &mesh);
  }
  faults->Add("a_flat_sheet.obj", mesh);
  const Vector3d low = Vector3d::Constant(-0.05);
  faults->Add("a_box_a_micrometre_thin.ply", MakeBox(low, {0.05, 0.05, -0.049999}));
  faults->Add("a_thread.obj", MakeBox(low, {0.05, -0.04999, -0.04999}));

  faults->Add("of_1e-12_metres.ply", ScaledBy(body, 2e-11));
  faults->Add("of_denormal_size.stl", ScaledBy(body, 2e-40));
  faults->Add("of_1e9_metres.ply", ScaledBy(body, 2e10));
  faults->Add("of_the_size_of_the_largest_float.stl", ScaledBy(body, 6e39));
  faults->Add("a_thousand_metres_away.obj", Moved(body, Vector3d(1e3, 1e3, 1e3)));
  faults->Add("a_million_metres_away.ply", Moved(body, Vector3d(1e6, 1e6, 1e6)));
  faults->Add("a_billion_metres_away.ply", Moved(body, Vector3d(1e9, 1e9, 1e9)));

  faults->Add("everything_at_once.ply", [&] {
    SurfaceMesh all = Apart(body, 1e-8, faults);
    for (Index t = 0; t < all.triangles.rows(); ++t) {
      if (faults->Draw(3) == 0) all.triangles.row(t).reverseInPlace();
    }
    for (int i = 0; i < 5; ++i) {
      const std::array<int, 3> again = Corners(all, DrawTriangle(all, faults));
      AddTriangle({again[0], again[2], again[1]}, &all);
      AddTriangle({again[1], again[1], again[0]}, &all);
      AddVertex(Vector3d(0.2, 0.2, 0.1 * i), &all);
    }
    return Without(all, static_cast<Index>(faults->Draw(80)), 1);
  }());
}

}  // namespace

void AddShapeFaults(MeshFaults* faults) {
  AddTriangleFaults(faults);
  AddTopologyFaults(faults);
  AddPartFaults(faults);
  AddSizeFaults(faults);
}

}  // namespace hpdm
