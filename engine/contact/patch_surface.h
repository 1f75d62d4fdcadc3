#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "engine/base/types.h"

namespace hpdm {

struct SurfacePatch;

/// Two contacts of one tip with one organ are apart if their unit normals are more than 30 degrees
/// apart. With less, one contact does.
inline bool IsApart(const Vector3d& normal_W, std::span<const Vector3d> others_W) {
  constexpr double kApartCosine = 0.866;
  for (const Vector3d& other_W : others_W) {
    if (normal_W.dot(other_W) > kApartCosine) return false;
  }
  return true;
}

/// The foot of a point on the surface of a patch.
struct SurfaceFoot {
  int triangle = -1;                         ///< Index among the surface's packed triangles.
  int mesh_triangle = -1;                    ///< Triangle number in the organ's mesh.
  std::array<std::uint8_t, 3> corners = {};  ///< The triangle's corners among SurfacePatch::points.
  Vector3d weights = Vector3d::Zero();       ///< Barycentric; they sum to 1.
  Vector3d normal_W = Vector3d::Zero();      ///< Outward, unit, interpolated.
  double gap = 0;                            ///< m, along the normal; negative inside.
};

/// The place of a surface that is nearest to a segment.
struct SegmentFoot {
  SurfaceFoot foot;
  double along = 0;      ///< Parameter (0..1) of the nearest point of the segment.
  double distance = 0;   ///< m; 0 where they cross.
  bool outside = false;  ///< The segment lies on the side to which the normal points.
};

/// The released surface of one SurfacePatch, packed for the queries of every tick. They find the foot
/// of a free tip's centre or of a free shaft's axis, and the place of a contact that slides along
/// the surface. The surface has at most kMaxTriangles triangles, so the cost does not depend on the
/// mesh.
///
/// 1. The foot of a free tip is the point q whose interpolated vertex normal passes through the
///    centre c: c = q + t n(q). This is the Phong projection (Panozzo, Baran, Diamanti,
///    Sorkine-Hornung 2013). Newton's method starts at the closest point and marches from triangle
///    to triangle.
/// 2. If no such q exists (missing normals, a crease, c beyond the centre of curvature) the foot is
///    the closest point. The sign of its gap comes from the triangle's own normal inside a face,
///    and from the interpolated normal on edges and at vertices.
/// 3. A tip beyond the patch has no foot: the closest point lies on the border and c is more than 1
///    um sideways of it. Border edges belong to one triangle only.
/// 4. A contact walks along the surface. The closest point would jump from side to side under a
///    convex edge, and in a thin part it may lie on the other side.
/// 5. A tip meets the curved surface over the flat triangles (curved_surface.h): the gap is counted
///    from it. A vertex counts as smooth by the faces that the patch has of it. At a sharp hollow
///    edge each wall keeps its own normal, at a sharp outer one the normals turn over one triangle.
/// 6. Triangles without area, with corners out of range or not finite are left out of the search,
///    but their edges do not count as border.
///
/// The deformation thread packs it, the haptic thread queries it; wait-free, no allocation, never
/// throws.
class PatchSurface {
 public:
  static constexpr int kMaxPoints = 64;
  static constexpr int kMaxTriangles = 96;

  /// Packs a patch: O(triangles).
  void Build(const SurfacePatch& patch) noexcept;

  bool empty() const noexcept { return triangle_count_ == 0; }
  /// True if the patch has a triangle of the organ's mesh.
  bool Has(int mesh_triangle) const noexcept;
  /// True if the point of the surface that is nearest to p_W (m) does not lie on its border.
  bool Covers(const Vector3d& p_W) const noexcept;
  /// True if a foot has reached the border.
  bool IsOnBorder(const SurfaceFoot& foot) const noexcept;

  /// Finds the foot of c_W (m) if its gap is at most `reach` (m). False if there is none.
  bool FindFoot(const Vector3d& c_W, double reach, SurfaceFoot* foot) const noexcept;
  /// True if the surface has a nearest point to c_W off its border, and c_W lies outside and farther than
  /// `distance` (m) from it.
  bool IsOutside(const Vector3d& c_W, double distance) const noexcept;

  /// Finds a foot of c_W within `reach` (m) beside other contacts of the same tip, whose normals are
  /// given: c_W lies outside, the distance to c_W grows on all sides of the foot, and the foot's
  /// normal is turned from all others (IsApart). The nearest one; false if there is none.
  bool FindBeside(const Vector3d& c_W, double reach, std::span<const Vector3d> normals_W,
                  SurfaceFoot* foot) const noexcept;

  /// Finds the place nearest to the segment from a_W to b_W (m). False if the surface is empty or
  /// the place lies on its border with the segment sideways of it: then nearer surface may follow.
  bool FindNearest(const Vector3d& a_W, const Vector3d& b_W, SegmentFoot* near) const noexcept;

  /// Finds where the segment from a_W to b_W (m) first crosses the surface from outside. False if
  /// it does not. Leaves the gap unchanged, as the following functions do.
  bool FindEntry(const Vector3d& a_W, const Vector3d& b_W, SurfaceFoot* foot) const noexcept;

  /// Finds the foot at a point of the surface, given by its triangle's number in the organ's mesh
  /// and its weights. A patch without that triangle uses the point closest to p_W. False if the
  /// patch has no surface within 5 mm of p_W.
  bool Find(int mesh_triangle, const Vector3d& weights, const Vector3d& p_W,
            SurfaceFoot* foot) const noexcept;

  /// Moves a foot along the surface by the tangential part of d_W (m), from triangle to triangle.
  /// At the border it slides along the border.
  void Walk(const Vector3d& d_W, SurfaceFoot* foot) const noexcept;

  /// Returns the offset (m) of the curved surface at a foot from its point of the flat triangle.
  Vector3d Offset(const SurfaceFoot& foot) const noexcept;

  /// Returns the change of the interpolated normal along the tangential part of d_W, per unit of
  /// d_W x 1 m.
  Vector3d Turn(const SurfaceFoot& foot, const Vector3d& d_W) const noexcept;

  /// The foot's point on the flat triangle, m.
  Vector3d Position(const SurfaceFoot& foot) const noexcept {
    return Interpolated(points_W_, foot.corners, foot.weights);
  }

 private:
  static constexpr std::uint8_t kNone = 0xff;
  using Corners = std::array<std::uint8_t, 3>;

  struct Closest {
    int triangle = -1;
    Vector3d weights = Vector3d::Zero();
    Vector3d offset_W = Vector3d::Zero();  // c - q
    double distance = 0;
  };
  int Slot(int mesh_triangle) const;
  Closest ClosestOn(int triangle, const Vector3d& c_W) const;
  Closest FindClosest(const Vector3d& c_W) const;
  bool FollowNormals(const Vector3d& c_W, const Closest& start, SurfaceFoot* foot) const;
  // Newton's method for p(w) + t n(w) = c on one triangle's plane, from `weights` and `t`. Sets `n`
  // to n(w). False if c lies beyond the centre of curvature or the iteration does not converge.
  void BoundOffset();
  bool SolveOnTriangle(const Vector3d& c_W, int triangle, Vector3d* weights, double* t,
                       Vector3d* n) const;
  bool IsLeast(const Closest& closest) const;
  void SetFoot(int triangle, const Vector3d& weights, SurfaceFoot* foot) const;
  std::array<Vector3d, 3> CornerNormals(int triangle) const;
  Vector3d NormalAt(int triangle, const Vector3d& weights) const;
  bool IsOnBorder(const Corners& corners, const Vector3d& weights) const;
  Vector3d Interpolated(const std::array<Vector3d, kMaxPoints>& values, const Corners& corners,
                        const Vector3d& weights) const {
    return weights[0] * values[corners[0]] + weights[1] * values[corners[1]] +
           weights[2] * values[corners[2]];
  }

  int triangle_count_ = 0;
  std::array<Vector3d, kMaxPoints> points_W_;
  std::array<Vector3d, kMaxPoints> normals_W_;  // zero where the patch gives none
  std::array<Vector3d, kMaxPoints> bends_W_;    // the same, zero at edges of the organ
  std::array<bool, kMaxPoints> is_notch_;       // on a sharp edge of the organ that is hollow
  double largest_offset_ = 0;                   // bound of Offset()'s length, m
  std::array<Corners, kMaxTriangles> triangles_;
  std::array<int, kMaxTriangles> mesh_triangles_;
  std::array<Vector3d, kMaxTriangles> face_normals_W_;  // unit
  // Bounding spheres of the triangles, to skip most of them.
  std::array<double, kMaxTriangles> centre_x_, centre_y_, centre_z_, radius_;
  // Triangle on the left of the directed edge (from, to); kNone, or kLeftOut if it was left out.
  static constexpr std::uint8_t kLeftOut = 0xfe;
  std::array<std::array<std::uint8_t, kMaxPoints>, kMaxPoints> left_of_;
};

}  // namespace hpdm
