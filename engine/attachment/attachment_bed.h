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
/// A sample of a leaf is a strip of it, at least 2 mm wide, from one organ to the other.
/// Built at set-up; any thread may read it.
struct AttachmentBed {
  static constexpr int kMaxSamples = 300;

  /// Points of the two surfaces that the attachment joins, at set-up.
  struct Facing {
    SurfacePoint on_a, on_b;
    Vector3d a_W, b_W, normal_W;
    double area = 0;
  };

  /// Samples a's surface in the region where b's surface faces it within the reach, or a leaf between
  /// the points nearest to its paths. Throws InputError if no surface does, if the bed is smaller than
  /// the cell of one function, if a path is farther than the reach from its organ, if a leaf has no
  /// length or would break at once, or if it overlaps a support. `index`: number of the attachment in
  /// the scene.
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
  Points edges_W;                    ///< M x 3, unit: of a leaf, along its lines. Else empty.
  Eigen::VectorXd areas;             ///< M, m^2, of the samples.
  double width = 0;                  ///< m, of a leaf's strips on the organs.
  std::array<WeightMatrix, 2> rows;  ///< M x n_a, M x n_b; without columns for a rigid organ.

  /// Returns the area of a sample on an organ's surface, m^2.
  double Footprint(int sample) const { return law.leaf ? width * width : areas[sample]; }

 private:
  void SampleLayer(const OrganModel& a, const OrganModel& b);
  void SampleLeaf(const OrganModel& a, const OrganModel& b);
  void TakeGroups(const std::vector<Facing>& facing,
                  const std::vector<std::vector<std::size_t>>& groups,
                  const std::array<const OrganModel*, 2>& organs);
};

/// Refuses two beds on the same surface (InputError).
void RefuseSharedSurface(const AttachmentBed& first, const AttachmentBed& second);

}  // namespace hpdm
