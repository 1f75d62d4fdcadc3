#pragma once

#include <array>
#include <vector>

#include "engine/attachment/cohesive_law.h"
#include "engine/mesh/collision.h"
#include "engine/organ.h"

namespace hpdm {

/// The facing surfaces of one attachment at rest, as M area samples. Each sample is a patch of at
/// least about 4 mm^2 whose relative displacement is
///     delta = rows[1] U_b - rows[0] U_a.
/// Built at set-up; any thread may read it.
struct AttachmentBed {
  static constexpr int kMaxSamples = 300;

  /// `index`: the attachment's, in the scene.
  /// Samples a's surface in the region where b's surface faces it within the reach. Throws
  /// InputError if no surface does, if the bed is smaller than the cell of one function, or if it
  /// overlaps a support.
  AttachmentBed(const AttachmentOptions& attachment, const OrganModel& a, const OrganModel& b,
                int index = 0);

  int size() const { return static_cast<int>(areas.size()); }

  AttachmentOptions options;
  int index;
  CohesiveLaw law;
  std::array<Points, 2> points_W;  ///< M x 3, m: on a and on b.
  /// M: the sampled point nearest to each of points_W, on a and on b.
  std::array<std::vector<SurfacePoint>, 2> surface_points;
  Points normals_W;                  ///< M x 3, unit: from a to b.
  Eigen::VectorXd areas;             ///< M, m^2.
  std::array<WeightMatrix, 2> rows;  ///< M x n_a, M x n_b; without columns for a rigid organ.
};

/// Refuses two beds on the same surface (InputError).
void RefuseSharedSurface(const AttachmentBed& first, const AttachmentBed& second);

}  // namespace hpdm
