#pragma once

#include <array>
#include <vector>

#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// Returns {cosine, sine} of a fraction of a full turn, by Taylor series after halving the angle
/// three times, so that the bits do not depend on a mathematics library.
std::array<double, 2> CosineSine(double turns);

/// Joins turned and milled solids into one mesh, each a closed surface that faces outwards.
class SolidBuilder {
 public:
  /// A closed polygon around a solid's axis, counter-clockwise as seen from the solid's far end.
  struct Ring {
    std::vector<Vector3d> points;  ///< m.
    bool half_step = false;        ///< Turned by half an edge against the ring it is zipped to.
  };

  /// Returns `count` points at even steps around an axis: centre + radius (cos u + sin v), with u x
  /// v along the axis towards the far end.
  static Ring Circle(const Vector3d& centre, const Vector3d& u, const Vector3d& v, double radius,
                     int count, bool half_step = false);

  /// Adds a tube over rings from its near to its far end, closed by a fan about a point at each
  /// end. The rings may have different numbers of points.
  void AddTube(const std::vector<Ring>& rings, const Vector3d& near_end, const Vector3d& far_end);

  /// Adds a bar over lines along +z, in counter-clockwise order as seen from +z, each with its own
  /// number of points at increasing z. The polygons of their first and of their last points close
  /// the bar and must be convex.
  void AddBar(const std::vector<std::vector<Vector3d>>& lines);

  SurfaceMesh Mesh() const;

 private:
  // Vertices along one side of a strip, and their places along it.
  struct Side {
    std::vector<int> vertices;
    std::vector<double> along;
  };

  int AddVertex(const Vector3d& p);
  std::vector<int> AddVertices(const std::vector<Vector3d>& points);
  // Adds the strip between two parallel sides, `b` to the left of `a` as seen from outside.
  void Zip(const Side& a, const Side& b);

  std::vector<Vector3d> vertices_;
  std::vector<std::array<int, 3>> triangles_;
};

}  // namespace hpdm
