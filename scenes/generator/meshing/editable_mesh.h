#pragma once

#include <array>
#include <vector>

#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// A closed, manifold, oriented triangle surface under local changes: collapse, split and flip of
/// an edge. Every operation that succeeds leaves it closed, manifold and oriented; indices of dead
/// vertices and triangles stay unused. Iterating by index is deterministic.
class EditableMesh {
 public:
  /// Takes a closed, manifold, oriented mesh; anything else is a bug.
  explicit EditableMesh(const SurfaceMesh& mesh);

  /// Returns the live vertices and triangles, renumbered in order.
  SurfaceMesh Compact() const;

  int vertex_capacity() const { return static_cast<int>(positions_.size()); }
  int triangle_capacity() const { return static_cast<int>(corners_.size()); }
  int triangle_count() const { return triangle_count_; }
  bool IsVertex(int v) const { return !stars_[v].empty(); }
  bool IsTriangle(int t) const { return corners_[t][0] >= 0; }
  const std::array<int, 3>& corners(int t) const { return corners_[t]; }
  const Vector3d& position(int v) const { return positions_[v]; }
  void set_position(int v, const Vector3d& p) { positions_[v] = p; }
  /// Triangles around v, in no particular (but reproducible) order.
  const std::vector<int>& star(int v) const { return stars_[v]; }
  int valence(int v) const { return static_cast<int>(stars_[v].size()); }

  /// Returns the vertices that share an edge with v, each once.
  std::vector<int> Neighbours(int v) const;
  bool HasEdge(int a, int b) const;

  /// Returns the triangles of edge ab: the one that runs a -> b, then the one that runs b -> a.
  std::array<int, 2> EdgeTriangles(int a, int b) const;
  /// Returns the third corner of each of these triangles.
  std::array<int, 2> OppositeVertices(int a, int b) const;

  /// Returns twice the area times the unit normal, m^2.
  Vector3d AreaVector(int t) const;
  Vector3d Centroid(int t) const;

  /// True if merging a and b keeps the surface manifold and every valence at least three (the link
  /// condition: a and b share exactly the two vertices opposite to their edge).
  bool CanCollapse(int a, int b) const;
  /// Merges `gone` into `keep` at p. Requires CanCollapse.
  void Collapse(int keep, int gone, const Vector3d& p);

  /// True if the edge between the opposite vertices may replace edge ab.
  bool CanFlip(int a, int b) const;
  void Flip(int a, int b);

  /// Splits edge ab with a new vertex at p and returns the vertex.
  int Split(int a, int b, const Vector3d& p);

 private:
  void ReplaceCorner(int t, int from, int to);
  void Detach(int t, int v);

  std::vector<Vector3d> positions_;
  std::vector<std::array<int, 3>> corners_;  ///< {-1, -1, -1} when dead.
  std::vector<std::vector<int>> stars_;      ///< Empty when dead.
  int triangle_count_ = 0;
};

/// Returns the squared sine of a triangle's smallest angle, 0 without area. It is monotonic,
/// because the smallest angle never exceeds 60 degrees.
double SmallestAngleMeasure(const Vector3d& a, const Vector3d& b, const Vector3d& c);

}  // namespace hpdm
