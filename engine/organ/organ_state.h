#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "engine/base/copying.h"
#include "engine/contact/contact_constraints.h"
#include "engine/contact/tip_compliance.h"
#include "engine/mesh/collision.h"
#include "engine/organ.h"
#include "engine/solver/maxwell_memory.h"
#include "engine/solver/relaxation.h"
#include "engine/tissue/lumen_leaks.h"

namespace hpdm {

/// The part of an organ that a step changes. Owned by the deformation thread. An assignment from a
/// state of the same mesh keeps the arrays in place.
struct OrganState {
  /// Makes room for at most `tools` tools. `clock`: see OrganModel::MakeRelaxation.
  OrganState(const OrganModel& model, int tools, std::function<Nanoseconds()> clock = nullptr);

  /// Returns where a row's point with displacement zero is taken to be, so that adding b U gives its
  /// place: `p_rest_W` (m), its distance from the row's mean rest point b X turned with the frame of
  /// a free organ. `row`: b.
  Vector3d TurnedRest(const OrganModel& model, const Vector3d& p_rest_W,
                      const Eigen::Ref<const Eigen::RowVectorXd>& row) const;
  /// Returns `p_rest_W` from the above.
  Vector3d RestOfTurned(const OrganModel& model, const Vector3d& turned_W,
                        const Eigen::Ref<const Eigen::RowVectorXd>& row) const;

  Vector3d offset_W = Vector3d::Zero();       ///< Rigid offset by breathing (OrganMotion), m.
  Vector3d offset_last_W = Vector3d::Zero();  ///< Offset in the previous step, m.
  Points control_displacements;  ///< (n + slots of local functions) x 3, m, world axes: U. Set by
                                 ///< reposition and relax.
  Points vertices;               ///< V x 3, m, world: X + B U, without indentations and the organ's
                                 ///< offset. Set by relocate.
  SurfaceTree tree;              ///< Over `vertices`. Refitted by collide after they moved.
  ContactConstraints contacts;   ///< Filled by collide, forces set by relax.
  NeighbourhoodSearch neighbourhoods;
  std::optional<NeighbourhoodSearch> coarse_neighbourhoods;  ///< On OrganModel::coarse_surface().
  Cloned<Relaxation> relaxation;
  MaxwellMemory memory;      ///< Around `relaxation`.
  LumenLeaks leaks;          ///< What its lumens have lost, and their pressures.
  RelaxationResult relaxed;  ///< Outcome of the last relaxation.
  StepQuality quality;       ///< Set before each step.

  /// True if a step must relax and relocate the organ: it is touched or still moves. An organ that
  /// is not awake is at rest to the last bit and costs only a collision test.
  bool awake = false;
  bool tree_fits = true;      ///< `tree` matches the present `vertices`.
  std::uint64_t version = 0;  ///< OrganSnapshot::version.

  TipCompliance tips;     ///< Tips on the organ. Filled when the contact patches are built.
  bool attached = false;  ///< Layers hold the organ: `relaxation` does not know of them.
  /// While tools are tracked and contact patches are built: the compliance with the layers' present
  /// damage, or else that of `relaxation`; null without a compliance (PresentCompliances).
  const LatticeCompliance* present_compliance = nullptr;
  /// Self-compliance of each vertex at rest, m/N: V symmetric 3 x 3; empty without a compliance.
  /// Constant; with the undamaged layers.
  std::shared_ptr<const std::vector<Matrix3d>> vertex_compliances;
};

}  // namespace hpdm
