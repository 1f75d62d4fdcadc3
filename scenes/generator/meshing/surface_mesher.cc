#include "scenes/generator/meshing/surface_mesher.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "engine/base/error.h"
#include "scenes/generator/meshing/editable_mesh.h"
#include "scenes/generator/meshing/marching_tetrahedra.h"
#include "scenes/generator/meshing/mesh_decimation.h"
#include "scenes/generator/meshing/remeshing.h"

namespace hpdm {
namespace {

/// Returns the area, m^2.
double SurfaceArea(const SurfaceMesh& mesh) {
  double twice_area = 0;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const Vector3d a = mesh.vertices.row(mesh.triangles(t, 0));
    const Vector3d b = mesh.vertices.row(mesh.triangles(t, 1));
    const Vector3d c = mesh.vertices.row(mesh.triangles(t, 2));
    twice_area += (b - a).cross(c - a).norm();
  }
  return twice_area / 2;
}

void ProjectAll(const ImplicitShape& shape, double level, SurfaceMesh* mesh) {
  for (Eigen::Index v = 0; v < mesh->vertices.rows(); ++v) {
    mesh->vertices.row(v) = ProjectToLevel(shape, mesh->vertices.row(v), level);
  }
}

/// Moves the vertices to the level near `level` at which the mesh encloses `volume`.
void MatchVolume(const ImplicitShape& shape, double level, double volume, SurfaceMesh* mesh) {
  // Newton's method on the level, with the area as the derivative of the volume.
  for (int iteration = 0; iteration < 8; ++iteration) {
    ProjectAll(shape, level, mesh);
    const double error = volume - EnclosedVolume(mesh->vertices, mesh->triangles);
    if (std::abs(error) < 1e-7 * volume) break;
    level += error / SurfaceArea(*mesh);
  }
}

}  // namespace

SurfaceMesh MeshImplicitSurface(const ImplicitShape& shape, const SurfaceMesherOptions& options) {
  if (options.triangle_count < 8 || options.triangle_count % 2 != 0) {
    throw InputError("surface mesher: triangle_count = " + std::to_string(options.triangle_count) +
                     ": a closed surface has an even number of triangles; ask for 8 or more");
  }
  SurfaceMesh mesh = MarchTetrahedra(shape, options.level, options.feature_size);
  // Remeshes to more triangles than requested, and finely enough for the shape. An equilateral
  // triangle of edge L has the area sqrt(3) / 4 L^2.
  const double dense_count = std::max(1.3 * options.triangle_count, 8000.0);
  const double edge_length = std::sqrt(SurfaceArea(mesh) / dense_count * 4 / std::sqrt(3.0));
  if (edge_length < options.feature_size) {
    mesh = MarchTetrahedra(shape, options.level, edge_length);
  }
  EditableMesh editable(mesh);
  RemeshIsotropically(shape, options.level, edge_length, 6, &editable);
  const double volume = LevelVolume(shape, options.level, editable.Compact());
  Decimate(options.triangle_count, &editable);
  RelaxOnSurface(shape, options.level, options.triangle_count < 10000 ? 20 : 4, &editable);
  mesh = editable.Compact();
  MatchVolume(shape, options.level, volume, &mesh);
  return mesh;
}

double LevelVolume(const ImplicitShape& shape, double level, const SurfaceMesh& mesh) {
  SurfaceMesh coarse = mesh;
  ProjectAll(shape, level, &coarse);
  // Splits every triangle in four, with the midpoints of its edges on the level set. Each volume is
  // a sum of tetrahedra to the origin, so midpoints need not be shared.
  double coarse_volume = 0, fine_volume = 0;
  const auto tetrahedron = [](const Vector3d& a, const Vector3d& b, const Vector3d& c) {
    return a.dot(b.cross(c)) / 6;
  };
  for (Eigen::Index t = 0; t < coarse.triangles.rows(); ++t) {
    const Vector3d a = coarse.vertices.row(coarse.triangles(t, 0));
    const Vector3d b = coarse.vertices.row(coarse.triangles(t, 1));
    const Vector3d c = coarse.vertices.row(coarse.triangles(t, 2));
    const Vector3d ab = ProjectToLevel(shape, 0.5 * (a + b), level);
    const Vector3d bc = ProjectToLevel(shape, 0.5 * (b + c), level);
    const Vector3d ca = ProjectToLevel(shape, 0.5 * (c + a), level);
    coarse_volume += tetrahedron(a, b, c);
    fine_volume += tetrahedron(a, ab, ca) + tetrahedron(ab, b, bc) + tetrahedron(ca, bc, c) +
                   tetrahedron(ab, bc, ca);
  }
  return fine_volume + (fine_volume - coarse_volume) / 3;
}

void DeepenToDistance(const ImplicitShape& shape, SurfaceMesh* mesh) {
  for (Eigen::Index v = 0; v < mesh->vertices.rows(); ++v) {
    const Vector3d p = mesh->vertices.row(v);
    const double depth = -shape.Sample(p).value;
    const Vector3d foot = NearestSurfacePoint(shape, p);
    const Vector3d gradient = shape.Sample(foot).gradient;
    mesh->vertices.row(v) = foot - gradient * (depth / gradient.norm());
  }
}

SurfaceMesh TurnedInsideOut(SurfaceMesh mesh) {
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    std::swap(mesh.triangles(t, 1), mesh.triangles(t, 2));
  }
  return mesh;
}

SurfaceMesh Joined(const SurfaceMesh& first, const SurfaceMesh& second) {
  const Eigen::Index vertex_count = first.vertices.rows(), triangle_count = first.triangles.rows();
  SurfaceMesh both;
  both.vertices.resize(vertex_count + second.vertices.rows(), 3);
  both.vertices.topRows(vertex_count) = first.vertices;
  both.vertices.bottomRows(second.vertices.rows()) = second.vertices;
  both.triangles.resize(triangle_count + second.triangles.rows(), 3);
  both.triangles.topRows(triangle_count) = first.triangles;
  both.triangles.bottomRows(second.triangles.rows()) =
      second.triangles.array() + static_cast<int>(vertex_count);
  return both;
}

}  // namespace hpdm
