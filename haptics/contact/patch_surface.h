#pragma once

#include <array>
#include <cstdint>

#include "engine/snapshots.h"

namespace hpdm {

/// Where a point stands over the surface of a patch.
struct SurfaceFoot {
  int triangle = -1;                         ///< Among the surface's packed triangles.
  int mesh_triangle = -1;                    ///< Its number in the organ's mesh.
  std::array<std::uint8_t, 3> corners = {};  ///< Its corners among ToolPatch::points.
  Vector3d weights = Vector3d::Zero();       ///< Barycentric; they sum to 1.
  Vector3d normal_W = Vector3d::Zero();      ///< Outward, unit, interpolated.
  double gap = 0;                            ///< m, along the normal; negative inside.
};

/// The released surface of one ToolPatch, packed for the questions of every tick: where does a free
/// tip's centre stand over it, and where does a contact get to that slides along it? At most
/// ToolPatch::kMaxTriangles triangles, so the cost does not depend on the mesh.
///
/// A free tip's foot is the point q whose interpolated vertex normal passes through the centre c,
/// c = q + t n(q) (Phong projection: Panozzo, Baran, Diamanti, Sorkine-Hornung 2013), found by
/// Newton's method from the closest point and marched from triangle to triangle. Where no such q
/// exists (missing normals, a crease, c beyond the centre of curvature) the foot is the closest
/// point, with the sign from the triangle's own normal inside a face and from the interpolated one
/// on edges and at vertices. There is no foot when the closest point lies on the patch's border (an
/// edge of one triangle only) and c is more than 1 um sideways of it: the tip is beyond the patch.
///
/// A tip in contact has no use for the closest point, which jumps from side to side under a convex
/// edge and lies on another side in a thin part: its contact walks along the surface.
///
/// Triangles without an area, with corners out of range or not finite are left out of the search,
/// but what they join is no border.
///
/// Haptic thread; wait-free, no allocation, never throws.
class PatchSurface {
 public:
  /// Packs a new patch: O(triangles).
  void Build(const ToolPatch& patch) noexcept;

  /// The foot of c_W (m) if its gap is at most `reach` (m); false when there is none.
  bool FindFoot(const Vector3d& c_W, double reach, SurfaceFoot* foot) const noexcept;

  /// Where the way from a_W to b_W (m) first crosses the surface from outside; false when it does
  /// not. The gap is left alone, here and below.
  bool FindEntry(const Vector3d& a_W, const Vector3d& b_W, SurfaceFoot* foot) const noexcept;

  /// The foot at a point of the surface: `mesh_triangle` is its triangle's number
  /// in the organ's mesh, p_W the point itself, for a patch without that triangle. False when the
  /// patch has no surface within 5 mm of p_W.
  bool Find(int mesh_triangle, const Vector3d& weights, const Vector3d& p_W,
            SurfaceFoot* foot) const noexcept;

  /// Moves a foot along the surface by d_W (m), of which only the tangential part counts, from
  /// triangle to triangle; at the border it goes along it.
  void Walk(const Vector3d& d_W, SurfaceFoot* foot) const noexcept;

  /// The foot's point, m.
  Vector3d Position(const SurfaceFoot& foot) const noexcept {
    return Interpolated(points_W_, foot.corners, foot.weights);
  }

 private:
  static constexpr int kMaxPoints = ToolPatch::kMaxPoints;
  static constexpr int kMaxTriangles = ToolPatch::kMaxTriangles;
  static constexpr std::uint8_t kNone = 0xff;
  using Corners = std::array<std::uint8_t, 3>;

  struct Closest {
    int triangle = -1;
    Vector3d weights = Vector3d::Zero();
    Vector3d offset_W = Vector3d::Zero();  // c - q
    double distance = 0;
  };
  Closest FindClosest(const Vector3d& c_W) const;
  bool FollowNormals(const Vector3d& c_W, const Closest& start, SurfaceFoot* foot) const;
  void SetFoot(int triangle, const Vector3d& weights, SurfaceFoot* foot) const;
  Vector3d NormalAt(int triangle, const Vector3d& weights) const;
  bool IsOnBorder(const Closest& closest) const;
  Vector3d Interpolated(const std::array<Vector3d, kMaxPoints>& values, const Corners& corners,
                        const Vector3d& weights) const {
    return weights[0] * values[corners[0]] + weights[1] * values[corners[1]] +
           weights[2] * values[corners[2]];
  }

  int triangle_count_ = 0;
  std::array<Vector3d, kMaxPoints> points_W_;
  std::array<Vector3d, kMaxPoints> normals_W_;  // zero where the patch gives none
  std::array<Corners, kMaxTriangles> triangles_;
  std::array<int, kMaxTriangles> mesh_triangles_;
  std::array<Vector3d, kMaxTriangles> face_normals_W_;  // unit
  // Spheres around the triangles, to leave most of them out.
  std::array<double, kMaxTriangles> centre_x_, centre_y_, centre_z_, radius_;
  // Triangle on the left of the directed edge (from, to): kNone, or kLeftOut when it was left out.
  static constexpr std::uint8_t kLeftOut = 0xfe;
  std::array<std::array<std::uint8_t, kMaxPoints>, kMaxPoints> left_of_;
};

}  // namespace hpdm
