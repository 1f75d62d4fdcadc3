#include "render/tissue/seams.h"

#include <array>
#include <map>

#include "engine/base/check.h"

namespace hpdm {

SeamedMesh CutSeams(const SurfaceMesh& mesh) {
  const int vertex_count = static_cast<int>(mesh.vertices.rows());
  SeamedMesh seamed;
  seamed.triangles = mesh.triangles;
  if (mesh.texture_coordinates.rows() == 0) {
    seamed.texture_coordinates.setZero(vertex_count, 2);
    return seamed;
  }
  HPDM_CHECK(mesh.texture_coordinates.rows() == 3 * mesh.triangles.rows());

  using Coordinate = std::array<float, 2>;
  std::vector<Coordinate> coordinates(mesh.vertices.rows());  // grows to R
  std::vector<bool> taken(mesh.vertices.rows());
  std::map<std::pair<int, Coordinate>, int> copy_of;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    for (int corner = 0; corner < 3; ++corner) {
      const int vertex = mesh.triangles(t, corner);
      const auto uv = mesh.texture_coordinates.row(3 * t + corner);
      const Coordinate coordinate = {static_cast<float>(uv.x()), static_cast<float>(uv.y())};
      if (!taken[vertex]) {
        taken[vertex] = true;
        coordinates[vertex] = coordinate;
      }
      if (coordinates[vertex] == coordinate) continue;
      const int next = vertex_count + static_cast<int>(seamed.copies.size());
      const auto [copy, added] = copy_of.emplace(std::pair(vertex, coordinate), next);
      if (added) {
        seamed.copies.push_back(vertex);
        coordinates.push_back(coordinate);
      }
      seamed.triangles(t, corner) = copy->second;
    }
  }
  seamed.texture_coordinates.resize(static_cast<Eigen::Index>(coordinates.size()), 2);
  for (std::size_t r = 0; r < coordinates.size(); ++r) {
    seamed.texture_coordinates.row(static_cast<Eigen::Index>(r)) << coordinates[r][0],
        coordinates[r][1];
  }
  return seamed;
}

}  // namespace hpdm
