#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/oriented_box.h"
#include "engine/base/types.h"
#include "engine/mesh/surface_mesh.h"
#include "engine/organ_options.h"

namespace hpdm {

/// The two functions of a crack's front at a point, and their gradients:
///     F1 = sqrt(r / h) sin(theta / 2),   F3 = F1 sin(theta)
/// They are the discontinuous two of the four branch functions (Moes, Dolbow, Belytschko 1999). r
/// is the distance from the front, theta the angle around it: 0 ahead, +-pi on the cut's sides. h
/// is a fixed length, so F has no unit.
struct FrontValues {
  std::array<double, 2> value = {0, 0};
  std::array<Vector3d, 2> gradient = {Vector3d::Zero(), Vector3d::Zero()};  ///< 1/m, world.
};

/// A cut of zero width in an organ at rest: the surface between consecutive blade edges, two
/// triangles each. Its border is a *front* where it lies in tissue. Constant once built; read by any
/// thread.
///
/// Whether two points lie on different sides is decided without rounding: points and triangles are
/// rounded to a grid of 2^-30 of the box's longest side, and their determinants are integers. A
/// point on a triangle's plane counts as on the side of its normal.
class CutSurface {
 public:
  using GridPoint = std::array<std::int64_t, 3>;
  using Triangle = std::array<Vector3d, 3>;

  /// `strip`: world, m. `rest_W`: the posed surface, which decides what lies in tissue. Throws
  /// InputError if the strip has no area, crosses itself, meets no tissue or is farther from the box
  /// than 500 of its sides.
  CutSurface(const OrientedBox& box_W, const CutOptions& strip, const SurfaceMesh& rest_W);

  /// Returns the grid point at lattice coordinates, or at a world point (m).
  GridPoint AtUnit(const Vector3d& c) const;
  GridPoint At(const Vector3d& p_W) const { return AtUnit(box_.ToUnit(p_W)); }
  /// True if the segment crosses a triangle.
  bool Crosses(const GridPoint& p, const GridPoint& q) const;

  const std::vector<Triangle>& triangles() const { return triangles_; }  ///< World, m.
  /// A point of the cut in tissue, world, m, and its share of the area, m^2.
  struct Sample {
    Vector3d p_W;
    double area;
  };
  /// Returns such points, about 1/64 of the box apart.
  const std::vector<Sample>& samples() const { return samples_; }

  /// True if a part of the border lies in tissue.
  bool has_front() const { return !front_.empty(); }
  /// Returns points of the border in tissue, world, m, at most 1/256 of the box apart.
  const std::vector<Vector3d>& front_points() const { return front_points_; }
  /// Distance of a point from the front, m, and the front's direction where it is nearest, unit.
  struct FrontPlace {
    double distance;  ///< Infinite without a front.
    Vector3d along;
  };
  FrontPlace NearestFront(const Vector3d& p_W) const;
  /// Evaluates the functions of the front with the length `h` (m) at `p_W` (m). On the cut itself,
  /// `side_W` shows the side. Without a front they are 0.
  FrontValues AtFront(const Vector3d& p_W, const Vector3d& side_W, double h) const;

 private:
  struct Segment {  // of the border
    Vector3d a, b;
    Vector3d normal_a, normal_b;  // of the cut, unit
    std::size_t triangle;
  };
  struct Nearest {
    Vector3d point;
    Vector3d normal;  // of the cut there, unit
    double distance;
    Vector3d along = Vector3d::UnitX();  // of a front, unit
  };

  void AddTriangles(const CutOptions& strip);
  void FindNormals();
  void FindTissue(const SurfaceMesh& rest_W);
  bool CrossesItself() const;
  Nearest NearestOnFront(const Vector3d& p_W) const;
  Nearest NearestOnCut(const Vector3d& p_W) const;

  OrientedBox box_;
  std::vector<Triangle> triangles_;
  std::vector<Vector3d> normals_;
  std::vector<std::array<GridPoint, 3>> on_grid_;
  std::vector<Segment> border_, front_;
  std::vector<Vector3d> front_points_;
  std::vector<Sample> samples_;
};

/// The cuts of an organ, at least one, all with the lattice's box; or nullptr.
using CutSurfaces = std::shared_ptr<const std::vector<CutSurface>>;

/// True if the segment crosses one of the cuts.
bool CrossesAny(const std::vector<CutSurface>& cuts, const CutSurface::GridPoint& p,
                const CutSurface::GridPoint& q);

}  // namespace hpdm
