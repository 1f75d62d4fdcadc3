#pragma once

#include "engine/mesh/surface_topology.h"
#include "engine/organ/organ_state.h"
#include "engine/snapshots.h"

namespace hpdm {

/// Returns the tool's pose relative to the organ's breathing offset (organ_motion.h). The velocity
/// stays in the world.
ToolPose InOrganFrame(const OrganState& state, ToolPose tool);

/// Returns the lattice's row at a vertex, valid until the next call.
SparseRow VertexRow(const OrganModel& model, int vertex, OrganState* state);

/// Contact of one tool's tip with an organ, as a deformation step sees it.
struct TipContact {
  int organ = -1;                          ///< Nearest to the tip, or in contact; -1: none.
  SurfacePoint at;                         ///< Material point under the tip.
  Neighbourhood around;                    ///< Around `at`, at rest.
  double gap = 0;                          ///< m, signed, from the tip's surface.
  bool from_tick = false;                  ///< The press comes from the haptic tick.
  Vector3d normal_W = Vector3d::Zero();    ///< Press normal; zero: not known yet.
  Vector3d friction_W = Vector3d::Zero();  ///< Press: tangential over normal force.

  // Set after the relaxation:
  bool touching = false;                 ///< The tip carried a force.
  Vector3d force_W = Vector3d::Zero();   ///< On the tissue, by tip or jaws, N.
  int tip = -1;                          ///< Index among the organ's tips; -1: reaction "paper".
  Matrix3d C_loc_W = Matrix3d::Zero();   ///< Local compliance of the press row, m/N.
  Matrix3d C_wall_W = Matrix3d::Zero();  ///< Its part that does not depend on the force, m/N.
  LocalIndentation indentation;          ///< The source of the other part.

  /// Gathers the neighbourhood of `at`.
  void UpdateNeighbourhood(const OrganModel& model, OrganState* state);
};

/// Returns the closest point to `p` on the neighbourhood's triangles with the given vertices.
SurfacePoint ClosestIn(const Neighbourhood& neighbourhood, const Points& vertices,
                       const Triangles& triangles, const Vector3d& p);

}  // namespace hpdm
