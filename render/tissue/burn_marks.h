#pragma once

#include <vector>

#include "engine/mesh/surface_mesh.h"
#include "engine/snapshots.h"

namespace hpdm {

/// The char marks that energised hooks leave where they press an organ, by vertices. A mark lies at the
/// point of the organ's surface that is nearest to the hook's tip. The contact itself may be several
/// millimetres away: it is a material point that friction holds. Marks grow from snapshot to snapshot,
/// so they belong to a picture and not to the session. Render thread only.
class BurnMarks {
 public:
  static constexpr double kReach = 0.004;  ///< m, from the mark's centre.
  static constexpr double kTime = 0.4;     ///< s, until its centre is black.
  static constexpr double kLongest = 0.1;  ///< s: a late snapshot burns no longer than this.
  /// m: a tip whose centre is farther from the surface leaves no mark.
  static constexpr double kFarthest = 0.004;

  /// `triangles`: of each organ's mesh; `vertices`: their numbers.
  BurnMarks(std::vector<Triangles> triangles, const std::vector<int>& vertices);

  /// Lets the marks grow by the time since the last call. True if one did.
  bool Follow(const SceneSnapshot& snapshot);

  /// How black each vertex of an organ is, 0..1.
  const std::vector<float>& Of(std::size_t organ) const { return black_[organ]; }

 private:
  bool Burn(std::size_t organ, const OrganSnapshot& shape, const Vector3d& p_tip_W, double dt);

  std::vector<Triangles> triangles_;
  std::vector<std::vector<float>> black_;
  Nanoseconds last_ns_ = 0;
};

}  // namespace hpdm
