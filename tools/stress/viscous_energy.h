#pragma once

#include <array>
#include <vector>

#include "engine/energy/maxwell_law.h"
#include "engine/organ/organ_state.h"

namespace hpdm {

/// Energy of a viscoelastic organ from step to step. Each branch k of the generalised Maxwell law is
/// a spring r_k K_t in series with a dashpot of the viscosity tau_k r_k K_t, with K_t the stiffness
/// without elastic supports. From the displacements of
/// two steps it integrates the springs' strains w_k by itself,
///     w_k(t) = a + (w_k(0) - a) exp(-t / tau_k),   a = tau_k dU/dt,
/// and the dashpots' power r_k w_k^T K_t w_k / tau_k over this course in closed form. It reads no force
/// that a hand feels and none of the branches of MaxwellMemory.
///
/// 1. The held tissue of a grasp has the same branches on its local stiffness.
/// 2. A dent's law has no stored energy that depends on its state alone (indentation_memory.h), so
///    the work of its contact force on it counts, by the trapezoidal rule from step to step.
///
/// Small strain, no local functions.
class ViscousEnergy {
 public:
  explicit ViscousEnergy(const OrganModel& model);

  /// Adds a step of `dt` s that ended in `state`.
  void Add(const OrganState& state, double dt);

  double stored() const { return stored_; }          ///< J, in all springs.
  double dissipated() const { return dissipated_; }  ///< J, by all dashpots, and the dents' work.

 private:
  // The branches' springs of a body with the displacements u and the stiffness K.
  struct Body {
    Eigen::VectorXd u;
    std::array<Eigen::VectorXd, PronySeries::kMaxTerms> w;
  };
  struct Dent {
    Vector3d u_W = Vector3d::Zero(), force_W = Vector3d::Zero();
  };

  template <class Stiffness>
  void Advance(const Eigen::VectorXd& u, double dt, const Stiffness& K, Body* body);
  template <class Stiffness>
  double InBranches(const Body& body, const Stiffness& K) const;
  void AddGrasp(const OrganState& state, int tool, double dt);
  void AddDents(const OrganState& state);

  const OrganModel& model_;
  const PronySeries& prony_;
  Body tissue_;
  std::array<Body, kMaxInstruments> held_;
  std::array<Dent, kMaxInstruments> dents_;
  double stored_ = 0;
  double dissipated_ = 0;
};

}  // namespace hpdm
