#pragma once

#include <array>
#include <utility>
#include <vector>

#include "engine/duct/duct_options.h"
#include "engine/duct/rod.h"
#include "engine/organ.h"

namespace hpdm {

/// A duct's constant part: its rod at rest and what holds its ends. A deforming organ holds an end by
/// the place and the rotation of its material there. Built at set-up; any thread may read it.
struct DuctModel {
  /// An end that a deforming organ holds. The organ moves it by four rows of its control points:
  ///     u = rows[0] U,     length du/dX_k = rows[1 + k] U.
  struct Hold {
    static constexpr int kRows = 4;
    std::array<std::vector<std::pair<int, double>>, kRows> rows;
    double length = 1;  ///< m: spacing of the control points, which gives all rows one unit.
  };

  /// `a`, `b`: the organs that hold the ends; nullptr: the world. `segments`: of the rod, at least
  /// four. Throws InputError if the path has no length or doubles back, or if an end lies neither in
  /// its organ nor within a radius of its surface. `number`: of the duct in the scene.
  DuctModel(const DuctOptions& duct, const OrganModel* a, const OrganModel* b, int number = 0,
            int segments = kDuctSegments);

  DuctOptions options;
  int index;
  TubeSection section;
  Rod rod;  ///< At rest.
  /// Empty rows if the end is held by the world or by a rigid organ.
  std::array<Hold, 2> holds;
  bool IsHeldByLattice(std::size_t end) const { return !holds[end].rows[0].empty(); }
};

/// Refuses two ducts of which a deforming organ holds two ends at one place (InputError).
void RefuseSharedEnds(const DuctModel& first, const DuctModel& second);

/// Returns `segments` + 1 points, equally far apart along a smooth curve through `path` (m).
Points EvenPath(const Points& path, int segments);

/// How a deforming organ turns an end's frame: the rotation of F = I + grad u, and the map from the
/// displacements w of the end's rows (4 x 3, m) to the end's small displacement and rotation.
struct EndMotion {
  Rod::Frame frame;
  Matrix3d turn;  ///< Rotation of the material.
  Eigen::Matrix<double, 6, 12> map;
};
/// `rest`: the end's frame at rest; `turn`: its rotation in the last step, which stays if the tissue is
/// inverted. Allocates nothing.
EndMotion EndMotionOf(const Rod::Frame& rest, double length, const Eigen::Matrix<double, 12, 1>& w,
                      const Matrix3d& turn);

}  // namespace hpdm
