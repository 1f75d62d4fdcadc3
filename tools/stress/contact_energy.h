#pragma once

#include <vector>

#include "engine/organ/organ_state.h"
#include "engine/snapshots.h"

/// Energy over a contact: what the hand puts in must be stored in the organ or dissipated.
namespace hpdm {

/// One tool in one haptic tick, as its energy is measured.
struct ContactTick {
  ContactKind kind = ContactKind::kNone;
  Vector3d p_tip_W = Vector3d::Zero();     ///< m.
  Vector3d reaction_W = Vector3d::Zero();  ///< On the hand, before the guard, N.
  Vector3d force_W = Vector3d::Zero();     ///< On the hand, displayed, N.
  Vector3d normal_W = Vector3d::Zero();    ///< Press: outward, unit; else zero.
  Vector3d friction_W = Vector3d::Zero();  ///< Press: tangential force on the tissue over f_n.
  /// Press: way of the contact's place over the tissue since the last tick, m.
  Vector3d slip_W = Vector3d::Zero();
};

/// Energy in the organ, J, after the step that solved it for the tool's pose of tick `tick`.
struct StoredEnergy {
  std::size_t tick = 0;
  double energy = 0;
  double dissipated = 0;  ///< By the material, since the start.
};

/// Energy of one contact in J: a run of ticks of one kind, and the tick after it.
struct ContactBalance {
  std::size_t first = 0;  ///< First tick in contact.
  std::size_t end = 0;    ///< First tick after it.
  ContactKind kind = ContactKind::kNone;
  int judged = 0;          ///< Instants at which the organ's energy is known.
  double put_in = 0;       ///< Work of the hand against the raw reaction where it is positive.
  double work = 0;         ///< All of it, the work that came back subtracted.
  double friction = 0;     ///< Dissipated by the slip under the tip.
  double guard = 0;        ///< Taken by the guard and the damping: work against displayed - raw.
  double most_stored = 0;  ///< Largest energy in the organ.
  double dissipated = 0;   ///< By the material, until the last judged instant.
  double unexplained = 0;  ///< Of largest size, at any judged instant: work - stored - dissipated.

  /// Unexplained energy over the work put in; 0 for a contact without work.
  double Error() const;
};

/// Returns the balance of each contact:
///
/// 1. Work is the trapezoidal sum of -reaction . d p_tip over the ticks. That is the work of the
///    contact law itself. The device holds a force over a tick; the energy of that hold is the
///    passivity observer's matter.
/// 2. Friction is the sum of the tangential force on the tissue, f_n friction, times the slip. The
///    slip is the way of the place over the tissue plus that over the ball, tip_radius d normal.
/// 3. What the material dissipates is given with the stored energy; elastic tissue dissipates
///    nothing.
/// 4. Instants are the ticks whose poses the steps solved (`stored`, ascending). Stored energy and
///    work then belong to the same pose, although the tick's force came from an older patch: what
///    the lag of the patches makes is part of the unexplained energy.
/// 5. A contact with elastic tissue that begins free starts at no energy. Any other starts at its
///    first instant. The organ of a press that ends free is at rest, which is the last instant.
/// 6. Viscoelastic tissue keeps its energy, stored and dissipated, while it is free. So a contact
///    that begins free starts at the energy of an instant since the last contact, and a press that
///    ends free ends at that of an instant before the next one, if there is one.
///
/// `tip_radius`: m.
std::vector<ContactBalance> BalancesOf(const std::vector<ContactTick>& ticks,
                                       const std::vector<StoredEnergy>& stored, double tip_radius);

/// Returns the energy of the organ after a step, J, from its shape: 1/2 U^T K U or the energy of
/// finite strain, plus the energy of what the lattice does not resolve at the contact rows. It
/// reads no force that a hand feels. Requires a model with a stiffness, without local functions.
double EnergyInOrgan(const OrganModel& model, const OrganState& state);

/// Returns the largest angle between any two of the forces, rad. Forces below `least` (N) do not
/// count.
double LargestTurn(const std::vector<Vector3d>& forces, double least);

/// Returns the root mean square of the speed between successive points, m/s; `period` in s.
double RmsSpeed(const std::vector<Vector3d>& points, double period);

}  // namespace hpdm
