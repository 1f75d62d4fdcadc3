#pragma once

#include <algorithm>

#include "engine/contact/half_space.h"
#include "engine/energy/maxwell_law.h"

namespace hpdm {

/// The memory of the dent under one tip in viscoelastic tissue (LocalIndentation). Its law is the
/// elastic one with the equilibrium force phi, the force after relaxation in the same position:
///     u = H q(phi_n) phi,   f = phi + sum_k r_k Z_k,   dZ_k/dt = dphi/dt - Z_k / tau_k.
/// For an indentation that grows this is the solution of Lee and Radok (1960); a held dent relaxes
/// as MaxwellStep says. Any thread, no allocation.
class IndentationMemory {
 public:
  /// Forgets all.
  void Clear() { *this = {}; }

  /// Moves the tip by `way` (m) over the surface, onto tissue that it has not dented yet. The dent
  /// fades as exp(-distance / radius), so a branch takes up the share 1 - exp(-way / radius) of it.
  void Slide(double way, double radius) {
    const double fresh = -std::expm1(-way / radius);
    for (Vector3d& branch : state_.branches) branch += fresh * (state_.at - branch);
  }

  /// Returns the law of the next step's contact. `free_W` gets the displacement without force, m.
  LocalIndentation Law(const LocalIndentation& elastic, const MaxwellStep& step,
                       Vector3d* free_W) const {
    const Vector3d& n = elastic.normal_W();
    const Vector3d dent_W = FreeForce(step);
    const double pressing = std::max(0.0, -n.dot(dent_W));
    const double yield = elastic.BallYield(pressing);
    const double across = elastic.BallYield(std::max(pressing, -n.dot(state_.at)));
    const Vector3d along_W = -pressing * n;
    const Vector3d across_W = dent_W - n.dot(dent_W) * n;
    *free_W = elastic.factor_W() * (yield * along_W + across * across_W);
    return elastic.WithMemory(step.stiffening, pressing);
  }

  /// Ends a step with the force `force_W` on the tissue, N.
  void Advance(const MaxwellStep& step, const Vector3d& force_W) {
    state_.Advance(step, force_W / step.stiffening + FreeForce(step));
  }

  /// Force that would remain after relaxation in this position, N.
  const Vector3d& equilibrium_force_W() const { return state_.at; }

 private:
  // Equilibrium force at the end of a step without force.
  Vector3d FreeForce(const MaxwellStep& step) const {
    Vector3d memory_W;
    state_.Memory(step, Vector3d::Zero(), &memory_W);
    return -memory_W / step.stiffening;
  }

  MaxwellState<Vector3d> state_{Vector3d::Zero(),
                                {Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()}};
};

}  // namespace hpdm
