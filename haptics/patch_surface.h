#pragma once

#include <array>
#include <cstdint>

#include "engine/snapshots.h"

namespace hpdm {

/// Where a point stands over the surface of a patch.
struct SurfaceFoot {
  std::array<std::uint8_t, 3> corners = {};  ///< Indices into ToolPatch::points.
  Vector3d weights = Vector3d::Zero();       ///< Barycentric; they sum to 1.
  Vector3d normal_W = Vector3d::Zero();      ///< Outward, unit.
  double gap = 0;                            ///< m, along the normal; negative inside.
};

/// The released surface of one ToolPatch, packed for the question of every tick: where does the
/// tip's centre stand over it? At most 96 triangles, so the cost does not depend on the mesh.
///
/// The answer is the point q whose interpolated vertex normal passes through the centre c,
/// c = q + t n(q) (Phong projection: Panozzo, Baran, Diamanti, Sorkine-Hornung 2013), found by
/// Newton's method from the closest point and marched from triangle to triangle. Neighbours
/// share the vertex normals, so foot, normal and gap change continuously as c moves, above and
/// below the surface. The closest point itself does not do: below a convex edge it jumps from one
/// side to the other and the force's direction with it. Where no such q exists (missing normals, a
/// crease, c beyond the centre of curvature) the foot is the closest point, with the sign from the
/// triangle's own normal inside a face and from the interpolated one on edges and at vertices.
///
/// Under a sharp convex edge there are several such q, one a side, and deeper than the radius of
/// curvature none, while the deformed tissue still presses from where the tip came in. So a tip in
/// contact keeps its side: the search starts at the last foot until Forget is called, also in the
/// next patch, whose released surface is the same. Where that leads nowhere near (the normal would
/// turn by more than 3.6 degrees), the last foot and its normal hold as long as c lies within 45
/// degrees of that normal. Otherwise the search starts at the closest point.
///
/// There is no foot when the closest point lies on the patch's border (an edge of one triangle
/// only) and c is more than 1 um sideways of it: the tip is beyond the patch. Triangles without an
/// area, with corners out of range or not finite are left out of the search, but what they join is
/// no border.
///
/// Haptic thread; wait-free, no allocation, never throws.
class PatchSurface {
 public:
  /// Packs a new patch: O(triangles).
  void Build(const ToolPatch& patch) noexcept;

  /// Finds the foot of c_W (m) if its gap is at most `reach` (m); false when there is none. The
  /// next search starts from it.
  bool FindFoot(const Vector3d& c_W, double reach, SurfaceFoot* foot) noexcept;

  /// The next search starts at this point of the patch, one that is known to be under the tip.
  void StartAt(const std::array<std::uint8_t, 3>& corners, const Vector3d& weights) noexcept;

  /// The next search starts at the closest point: the tip is no longer in contact.
  void Forget() noexcept { has_last_ = false; }

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
  bool FindFootFromLast(const Vector3d& c_W, double reach, SurfaceFoot* foot) const;
  bool FindFootFromClosest(const Vector3d& c_W, double reach, SurfaceFoot* foot) const;
  // `least_area`: of the offset surface at c over the released one, at every step.
  bool FollowNormals(const Vector3d& c_W, const Closest& start, double least_area,
                     SurfaceFoot* foot) const;
  bool IsOnBorder(const Closest& closest) const;
  Vector3d Interpolated(const std::array<Vector3d, kMaxPoints>& values, const Corners& corners,
                        const Vector3d& weights) const {
    return weights[0] * values[corners[0]] + weights[1] * values[corners[1]] +
           weights[2] * values[corners[2]];
  }

  bool has_last_ = false;
  Vector3d p_last_W_ = Vector3d::Zero();  // the last foot, on the released surface
  Vector3d normal_last_W_ = Vector3d::Zero();
  int triangle_count_ = 0;
  std::array<Vector3d, kMaxPoints> points_W_;
  std::array<Vector3d, kMaxPoints> normals_W_;  // zero where the patch gives none
  std::array<Corners, kMaxTriangles> triangles_;
  std::array<Vector3d, kMaxTriangles> face_normals_W_;  // unit
  // Spheres around the triangles, to leave most of them out.
  std::array<double, kMaxTriangles> centre_x_, centre_y_, centre_z_, radius_;
  // Triangle on the left of the directed edge (from, to): kNone, or kLeftOut when it was left out.
  static constexpr std::uint8_t kLeftOut = 0xfe;
  std::array<std::array<std::uint8_t, kMaxPoints>, kMaxPoints> left_of_;
};

}  // namespace hpdm
