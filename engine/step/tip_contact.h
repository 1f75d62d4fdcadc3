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

/// Contact of one tool's tip with an organ, as a deformation step sees it. The part of a shaft that
/// presses counts as a tip too: a ball of the shaft's radius.
struct TipContact {
  int organ = -1;          ///< Nearest to the tip, or in contact; -1: none.
  SurfacePoint at;         ///< Material point under the tip.
  Neighbourhood around;    ///< Around `at`, at rest.
  double gap = 0;          ///< m, signed, from the tip's surface.
  bool from_tick = false;  ///< The press comes from the haptic tick.
  bool beside =
      false;  ///< The tip has another place on the organ. Only the tick begins a press here.
  Vector3d normal_W = Vector3d::Zero();    ///< Press normal; zero: not known yet.
  Vector3d friction_W = Vector3d::Zero();  ///< Press: tangential over normal force.
  Vector3d axis_W = Vector3d::Zero();      ///< Shaft: its axis, unit; zero for a tip.

  bool is_shaft() const { return !axis_W.isZero(0); }
  // Set after the relaxation:
  int row = -1;                                     ///< Press: its contact row; -1: none.
  bool touching = false;                            ///< The tip carried a force.
  Vector3d force_W = Vector3d::Zero();              ///< On the tissue, by tip or jaws, N.
  Vector3d equilibrium_force_W = Vector3d::Zero();  ///< Press on viscoelastic tissue: the force
                                                    ///< that would remain after relaxation, N.
  int tip = -1;        ///< Index among the organ's tips; -1: reaction "paper", or `alone`.
  bool alone = false;  ///< A shaft near the organ that does not touch it: felt, but no tip.
  CoupledRow coupled;  ///< Press: its dent's compliance to the tip's other places on the organ.
  Matrix3d C_loc_W = Matrix3d::Zero();   ///< Local compliance of the press row, m/N.
  Matrix3d C_wall_W = Matrix3d::Zero();  ///< Its part that does not depend on the force, m/N.
  LocalIndentation indentation;          ///< The source of the other part.

  /// Gathers the neighbourhood of `at`.
  void UpdateNeighbourhood(const OrganModel& model, OrganState* state);
};

/// Returns the unit vector along the part of `v_W` across a unit axis; zero if there is none.
inline Vector3d Across(const Vector3d& axis_W, const Vector3d& v_W) {
  return (v_W - axis_W.dot(v_W) * axis_W).stableNormalized();
}

/// True if the hand feels the organ by the lattice's own compliance, which a free organ always gives,
/// or by a rigid organ's wall.
inline bool HasLattice(ReactionType reaction, const OrganModel& model, const OrganState& state) {
  return model.rigid() || model.options().free.has_value() ||
         (reaction == ReactionType::kLattice && state.relaxation->compliance() != nullptr);
}

/// Condenses contact row number `row` to the organ's next tip, or as another row of the contact's
/// own, after the relaxation. `owner`: see TipCompliance::AddTip. Without `has_lattice` it only adds
/// the row's force.
void AddRowToTip(int row, int owner, bool has_lattice, OrganState* state, TipContact* contact);

/// Returns the closest point to `p` on the neighbourhood's triangles with the given vertices.
SurfacePoint ClosestIn(const Neighbourhood& neighbourhood, const Points& vertices,
                       const Triangles& triangles, const Vector3d& p);

}  // namespace hpdm
