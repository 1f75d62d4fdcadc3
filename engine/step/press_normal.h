#pragma once

#include <array>

#include "engine/base/work_array.h"
#include "engine/contact/surface_kernel.h"
#include "engine/organ/organ_state.h"

namespace hpdm {

/// The tilt of the surface under a press: the mean of the triangles' normals, weighted by a kernel
/// (surface_kernel.h), less the same at rest, turned with the frame of a free organ. It varies smoothly as the contact moves over the
/// triangles. With the kernel of the lattice's row the mean slope of the displacement is the
/// derivative of the row's own displacement along the surface, so that a press along the tilted
/// normal gives no energy and takes none as it slides.
///
/// Deformation thread; bounded, allocates nothing.
class PressNormal {
 public:
  /// Gathers the kernel of `radius` (m) about a point of the rest surface, from the triangles of the
  /// nearest kMaxVertices vertices if it covers more.
  void Gather(const OrganModel& model, const SurfacePoint& at, double radius, OrganState* state);
  /// Does the same with a kernel that GatherKernel() has gathered from a neighbourhood of the point at
  /// rest, within the radius. Only if TakesAll().
  void Take(const KernelSamples& kernel);
  static bool TakesAll(const Neighbourhood& around) { return around.vertex_count <= kMaxVertices; }

  /// Returns the tilt after the step.
  Vector3d Tilt(const OrganModel& model, const OrganState& state) const {
    return Mean(model, state.vertices) -
           state.relaxation->Rotation() * Mean(model, model.rest().vertices);
  }
  /// Returns its change for a further unit force on a condensed tip of the organ, 1/N.
  Matrix3d Compliance(const OrganModel& model, int tip, OrganState* state);

 private:
  static constexpr int kMaxVertices = 160;

  // A triangle under the kernel with its share of the weight.
  struct Share {
    int triangle;
    double weight;
  };

  Vector3d Mean(const OrganModel& model, const Points& vertices) const;

  WorkArray<Share> shares_{Neighbourhood::kMaxTriangles};
  int count_ = 0;
};

}  // namespace hpdm
