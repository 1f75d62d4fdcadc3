#pragma once

#include <memory>

#include "engine/contact/contact_solver.h"
#include "engine/contact/lattice_compliance.h"
#include "engine/energy/metric_energy.h"
#include "engine/energy/strain_energy.h"
#include "engine/solver/refinement_basis.h"
#include "engine/solver/step_quality.h"

namespace hpdm {

/// m: an organ whose displacements are all smaller counts as still.
inline constexpr double kStill = 1e-9;

class ElasticSupports;

/// Inputs of a relaxation besides the contacts. A quadratic energy needs only `free` and `yield`.
/// Viscoelastic tissue (maxwell_memory.h) gives both `damping` and these.
struct RelaxationInput {
  StepQuality quality = {};
  /// > 0: the number of iterations after which to stop, in place of the time budget. A replay gives
  /// it where the recorded relaxation was out of time.
  int stop_after = 0;
  /// Starts at these displacements (n x 3, m) instead of where the last Relax ended, unless nullptr.
  const Points* start = nullptr;
  /// > 0: adds a damper, which starts at `damped_from` (n x 3, m):
  ///     dE/dU + damping K_t (U - damped_from) = B^T f,   K_t: stiffness at rest without `supports`.
  double damping = 0;
  const Points* damped_from = nullptr;
  /// A quadratic energy: the displacements are U_free + yield K^-1 B^T f, with U_free = `free`
  /// ((n + slots) x 3, m), or zero. For a body that moves as a whole `free` is in its frame.
  const Points* free = nullptr;
  double yield = 1;
  /// Supports that do not relax with viscoelastic tissue, which yield more by their own part of the
  /// response at `damping`; nullptr: none.
  ElasticSupports* supports = nullptr;
};

class ContactBody;

/// Stage B of a step: finds the control displacements of least energy E(U) that satisfy the
/// contacts (engine/README.md, section 4),
///     dE/dU = B^T f,   x = p_rest + B U + C_loc f
///     grasp:   x = target
///     press:   f = f_n (friction - n),   f_n >= 0,   g = n . (target - x) >= 0,   f_n g = 0.
/// The implementations below have a constant K, E = 1/2 U^T K U. elastic_relaxation.h has the one
/// for strain of any size. Organs that touch each other are solved together as their body()
/// (contact_body.h).
class Relaxation {
 public:
  virtual ~Relaxation() = default;
  /// Returns a copy that continues from the same state to the last bit. Allocates.
  virtual std::unique_ptr<Relaxation> Clone() const = 0;
  /// Takes the state of another one of the same class and organ. Allocates nothing.
  virtual void Take(const Relaxation& other) = 0;
  /// Solves an organ without neighbours: `U` (n x 3, m) and the rows' forces. On entry `U` is the
  /// start, stage A's moved control points, which only Gauss-Seidel uses. The first call may
  /// allocate.
  RelaxationResult Relax(ContactConstraints* contacts, Points* U,
                         const RelaxationInput& input = {}) {
    return DoRelax(input, contacts, U);
  }

  /// True if the solver has no remaining internal motion: a Relax without contacts that gave U = 0
  /// would give it again. Such a Relax ends motions below kStill a step.
  virtual bool AtRest() const { return true; }

  /// Sets the local functions in use, for compliance(); Relax does the same.
  virtual void SetActiveFunctions(const ActiveRefinement& /*active*/) {}

  /// Returns the lattice's response to small changes of the loads, for the contact patch. It lives
  /// as long as the relaxation. nullptr if there is none; the hand then feels reaction "paper".
  virtual const LatticeCompliance* compliance() const { return nullptr; }

  /// Returns the rotation of the organ's floating frame from its rest pose (free_body.h); the
  /// identity without one.
  virtual Matrix3d Rotation() const { return Matrix3d::Identity(); }

  /// Returns the energy of a body that moves as a whole, J: that of its motion, and of its weight over its
  /// rest pose. 0 for others. `U`: the displacements of its last step, m.
  virtual double BodyEnergy(const Points& /*U*/) const { return 0; }

  /// The organ as a body of a problem with others; nullptr: it takes no contacts with organs.
  virtual ContactBody* body() { return nullptr; }

 private:
  virtual RelaxationResult DoRelax(const RelaxationInput& input, ContactConstraints* contacts,
                                   Points* U) = 0;
};

/// Iteration budget and tolerance of Gauss-Seidel. The budget is a count, not a time, so a lockstep
/// run is reproducible.
struct GaussSeidelOptions {
  int max_sweeps = 2000;
  /// Largest residual, and largest violation of the contacts over the largest change.
  double tolerance = 1e-6;
};

/// Make a direct solver. `K`: n x n or 3n x 3n, symmetric positive definite (energy plus supports).
/// Throw InputError if it is not.
std::unique_ptr<Relaxation> MakeCholeskyRelaxation(const ScalarStiffness& K);
std::unique_ptr<Relaxation> MakeCholeskyRelaxation(const FullStiffness& K);
/// Makes a direct solver with local functions in at most `slots` slots; `functions` must outlive
/// it.
std::unique_ptr<Relaxation> MakeCholeskyRelaxation(const RefinementBasis& functions, int slots);

/// Makes the relaxation of a rigid organ: no unknowns. Only each contact's own local compliance, a
/// virtual wall, responds.
std::unique_ptr<Relaxation> MakeRigidRelaxation();

/// Make the paper's solver, with one block of three unknowns for each control point. An augmented
/// Lagrangian extends it by the contacts; its multipliers change after each sweep. The result of
/// compliance() comes from the inverse of the same K, computed at set-up.
std::unique_ptr<Relaxation> MakeGaussSeidelRelaxation(const ScalarStiffness& K,
                                                      const GaussSeidelOptions& options = {});
std::unique_ptr<Relaxation> MakeGaussSeidelRelaxation(const FullStiffness& K,
                                                      const GaussSeidelOptions& options = {});

}  // namespace hpdm
