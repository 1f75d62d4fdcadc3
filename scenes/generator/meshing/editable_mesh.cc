#include "scenes/generator/meshing/editable_mesh.h"

#include <algorithm>
#include <iterator>

#include "engine/base/check.h"

namespace hpdm {

EditableMesh::EditableMesh(const SurfaceMesh& mesh)
    : positions_(mesh.vertices.rows()),
      corners_(mesh.triangles.rows()),
      stars_(mesh.vertices.rows()),
      triangle_count_(static_cast<int>(mesh.triangles.rows())) {
  for (int v = 0; v < vertex_capacity(); ++v) positions_[v] = mesh.vertices.row(v);
  for (int t = 0; t < triangle_capacity(); ++t) {
    for (int k = 0; k < 3; ++k) {
      corners_[t][k] = mesh.triangles(t, k);
      stars_[corners_[t][k]].push_back(t);
    }
  }
}

SurfaceMesh EditableMesh::Compact() const {
  std::vector<int> number(positions_.size(), -1);
  int vertex_count = 0;
  for (int v = 0; v < vertex_capacity(); ++v) {
    if (IsVertex(v)) number[v] = vertex_count++;
  }
  SurfaceMesh mesh;
  mesh.vertices.resize(vertex_count, 3);
  for (int v = 0; v < vertex_capacity(); ++v) {
    if (number[v] >= 0) mesh.vertices.row(number[v]) = positions_[v];
  }
  mesh.triangles.resize(triangle_count_, 3);
  int row = 0;
  for (int t = 0; t < triangle_capacity(); ++t) {
    if (!IsTriangle(t)) continue;
    for (int k = 0; k < 3; ++k) mesh.triangles(row, k) = number[corners_[t][k]];
    ++row;
  }
  return mesh;
}

std::vector<int> EditableMesh::Neighbours(int v) const {
  // On a closed oriented surface every neighbour follows v in exactly one triangle.
  std::vector<int> neighbours;
  neighbours.reserve(stars_[v].size());
  for (const int t : stars_[v]) {
    const std::array<int, 3>& c = corners_[t];
    neighbours.push_back(c[0] == v ? c[1] : c[1] == v ? c[2] : c[0]);
  }
  return neighbours;
}

bool EditableMesh::HasEdge(int a, int b) const {
  for (const int t : stars_[a]) {
    for (const int v : corners_[t]) {
      if (v == b) return true;
    }
  }
  return false;
}

std::array<int, 2> EditableMesh::EdgeTriangles(int a, int b) const {
  std::array<int, 2> triangles = {-1, -1};
  for (const int t : stars_[a]) {
    const std::array<int, 3>& c = corners_[t];
    for (int k = 0; k < 3; ++k) {
      if (c[k] == a && c[(k + 1) % 3] == b) triangles[0] = t;
      if (c[k] == b && c[(k + 1) % 3] == a) triangles[1] = t;
    }
  }
  HPDM_CHECK(triangles[0] >= 0 && triangles[1] >= 0);
  return triangles;
}

std::array<int, 2> EditableMesh::OppositeVertices(int a, int b) const {
  const std::array<int, 2> triangles = EdgeTriangles(a, b);
  std::array<int, 2> opposite = {-1, -1};
  for (int side = 0; side < 2; ++side) {
    for (const int v : corners_[triangles[side]]) {
      if (v != a && v != b) opposite[side] = v;
    }
  }
  return opposite;
}

Vector3d EditableMesh::AreaVector(int t) const {
  const std::array<int, 3>& c = corners_[t];
  return (positions_[c[1]] - positions_[c[0]]).cross(positions_[c[2]] - positions_[c[0]]);
}

Vector3d EditableMesh::Centroid(int t) const {
  const std::array<int, 3>& c = corners_[t];
  return (positions_[c[0]] + positions_[c[1]] + positions_[c[2]]) / 3;
}

bool EditableMesh::CanCollapse(int a, int b) const {
  // Each merged triangle pair takes one edge off both opposite vertices.
  for (const int v : OppositeVertices(a, b)) {
    if (valence(v) <= 3) return false;
  }
  if (valence(a) + valence(b) - 4 < 3) return false;
  std::vector<int> around_a = Neighbours(a), around_b = Neighbours(b);
  std::sort(around_a.begin(), around_a.end());
  std::sort(around_b.begin(), around_b.end());
  std::vector<int> common;
  std::set_intersection(around_a.begin(), around_a.end(), around_b.begin(), around_b.end(),
                        std::back_inserter(common));
  return common.size() == 2;
}

void EditableMesh::Collapse(int keep, int gone, const Vector3d& p) {
  for (const int t : EdgeTriangles(keep, gone)) {
    for (const int v : corners_[t]) Detach(t, v);
    corners_[t] = {-1, -1, -1};
    --triangle_count_;
  }
  for (const int t : stars_[gone]) {
    ReplaceCorner(t, gone, keep);
    stars_[keep].push_back(t);
  }
  stars_[gone].clear();
  positions_[keep] = p;
}

bool EditableMesh::CanFlip(int a, int b) const {
  if (valence(a) <= 3 || valence(b) <= 3) return false;
  const std::array<int, 2> opposite = OppositeVertices(a, b);
  return !HasEdge(opposite[0], opposite[1]);
}

void EditableMesh::Flip(int a, int b) {
  const std::array<int, 2> triangles = EdgeTriangles(a, b);
  const std::array<int, 2> opposite = OppositeVertices(a, b);
  Detach(triangles[1], a);
  Detach(triangles[0], b);
  corners_[triangles[0]] = {a, opposite[1], opposite[0]};
  corners_[triangles[1]] = {b, opposite[0], opposite[1]};
  stars_[opposite[0]].push_back(triangles[1]);
  stars_[opposite[1]].push_back(triangles[0]);
}

int EditableMesh::Split(int a, int b, const Vector3d& p) {
  const std::array<int, 2> triangles = EdgeTriangles(a, b);
  const std::array<int, 2> opposite = OppositeVertices(a, b);
  const int middle = vertex_capacity();
  positions_.push_back(p);
  stars_.emplace_back();
  for (int side = 0; side < 2; ++side) {
    const int t = triangles[side], added = triangle_capacity();
    // The old triangle keeps a, its new half keeps b.
    corners_.push_back(corners_[t]);
    ReplaceCorner(added, a, middle);
    ReplaceCorner(t, b, middle);
    Detach(t, b);
    stars_[b].push_back(added);
    stars_[opposite[side]].push_back(added);
    stars_[middle].push_back(t);
    stars_[middle].push_back(added);
    ++triangle_count_;
  }
  return middle;
}

void EditableMesh::ReplaceCorner(int t, int from, int to) {
  for (int& corner : corners_[t]) {
    if (corner == from) corner = to;
  }
}

void EditableMesh::Detach(int t, int v) {
  stars_[v].erase(std::find(stars_[v].begin(), stars_[v].end(), t));
}

double SmallestAngleMeasure(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const double ab = (b - a).squaredNorm(), bc = (c - b).squaredNorm(), ca = (a - c).squaredNorm();
  const double longest = std::max({ab, bc, ca}), shortest = std::min({ab, bc, ca});
  // The smallest angle lies opposite to the shortest edge, between the two others.
  const double others = ab * bc * ca / shortest;
  if (!(longest > 0 && others > 0)) return 0;
  return (b - a).cross(c - a).squaredNorm() / others;
}

}  // namespace hpdm
