#pragma once

#include <array>

#include "engine/contact/surface_kernel.h"
#include "engine/organ/organ_state.h"

namespace hpdm {

/// The outward unit normal of the surface under a press: the mean of the vertex normals, weighted
/// by a kernel (surface_kernel.h). It varies smoothly as the contact moves over the triangles.
/// Deformation thread; bounded, allocates nothing.
class PressNormal {
 public:
  /// Gathers the kernel of `radius` (m) about a point of the rest surface, from the nearest
  /// vertices if it covers more than KernelPatch holds.
  void Gather(const OrganModel& model, const SurfacePoint& at, double radius, OrganState* state);

  /// Returns the mean of the given vertex normals (V x 3). Zero if they cancel.
  Vector3d Mean(const Points& normals) const;
  /// Returns the normal of the surface after the step. Zero if no triangle has area.
  Vector3d Pressed(const OrganModel& model, const OrganState& state) const;
  /// Returns its change for a further unit force on a condensed tip of the organ, 1/N.
  Matrix3d Compliance(const OrganModel& model, int tip, OrganState* state);

 private:
  // Vertices in the rings around those of the kernel; further ones move with their ring's centre.
  static constexpr int kMaxMoved = 384;
  static constexpr int kSlots = 1024;  // of the hash table

  const Matrix3d& MovedBy(int tip, int vertex, int centre, const OrganModel& model,
                          OrganState* state);

  Neighbourhood around_;
  KernelPatch kernel_;
  int moved_count_ = 0;
  std::array<int, kSlots> moved_vertex_{};  // -1: free
  std::array<Matrix3d, kSlots> moved_;      // displacement for a unit force on the tip, m/N
};

}  // namespace hpdm
