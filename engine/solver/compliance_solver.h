#pragma once

#include <memory>

#include "engine/contact/contact_solver.h"
#include "engine/contact/lattice_compliance.h"
#include "engine/energy/metric_energy.h"
#include "engine/energy/strain_energy.h"
#include "engine/solver/refinement_basis.h"
#include "engine/solver/relaxation.h"

namespace hpdm {

/// The response U = K^-1 R of a lattice of constant stiffness K to loads R, with K inverted once.
/// Owned by one thread; Respond() and Deform() allocate nothing.
class ComplianceSolver : public LatticeCompliance {
 public:
  /// Returns a copy in the same state. Copies share K^-1. Allocates.
  virtual std::unique_ptr<ComplianceSolver> Clone() const = 0;
  /// Takes the state of another one of the same class and lattice. Allocates nothing.
  virtual void Take(const ComplianceSolver& other) = 0;

  /// Sets the local functions in use; Respond() does the same with those of its contacts. Does
  /// nothing if the solver has no local functions.
  virtual void SetActiveFunctions(const ActiveRefinement& active) { static_cast<void>(active); }

  /// Adds yield B_c K^-1 B_c^T to the compliance of `contact_solver`, in which `contacts` are those
  /// of number `body`. Keeps the data of the contacts that Deform() needs.
  virtual void Respond(int body, const ContactConstraints& contacts, double yield,
                       ContactSolver* contact_solver) = 0;

  /// Computes U = K^-1 B^T f (n x 3, m; with local functions their slots follow) under the forces
  /// of `contact_solver`, which the last Respond() saw.
  virtual void Deform(int body, const ContactSolver& contact_solver, Points* U) const = 0;
};

/// Adds the compliance between the equations of `contact_solver`, in which `contacts` are those of
/// number `body`,
///     A_eg = axis_e . (b_e U_g),
/// which is `yield` times that after relaxation, with column i of `response` (3n x >= sides) the displacements U_g for a unit force of the body's
/// side i, in equation g.
void AddCompliance(int body, const ContactConstraints& contacts,
                   const Eigen::Ref<const Eigen::MatrixXd>& response, double yield,
                   ContactSolver* contact_solver);

/// Takes the displacements U ((n + slots) x 3, m) off the changes of the body's equations.
void TakeOffChanges(int body, const ContactConstraints& contacts, const Points& U,
                    ContactSolver* contact_solver);

/// A quadratic energy as a ContactBody: Linearise() and Advance() for
///     U = input.free + (input.yield K^-1 + Phi D Phi^T) B^T f
/// with the part Phi D Phi^T of input.supports (elastic_supports.h).
void LineariseQuadratic(int body, const ContactConstraints& contacts, const RelaxationInput& input,
                        ComplianceSolver* compliance_solver, ContactSolver* contact_solver);
void AdvanceQuadratic(int body, const RelaxationInput& input,
                      const ComplianceSolver& compliance_solver,
                      const ContactSolver& contact_solver, Points* U);

/// Returns K^-1. A contact's row b has few entries, one for each non-zero function (27 of quadratic
/// splines). So a product with those columns of K^-1 is several times cheaper than two triangular
/// solves. Throws InputError (`remedy`) if K is not positive definite beyond round-off.
Eigen::MatrixXd InverseStiffness(const Eigen::Ref<const Eigen::MatrixXd>& K, const char* remedy);

/// Make a solver with a dense K^-1. Throw InputError if K is not positive definite.
std::unique_ptr<ComplianceSolver> MakeComplianceSolver(const ScalarStiffness& K);
std::unique_ptr<ComplianceSolver> MakeComplianceSolver(const FullStiffness& K);

/// Makes a solver with local functions in at most `slots` slots (enriched_compliance_solver.h).
/// `functions` must outlive it.
std::unique_ptr<ComplianceSolver> MakeComplianceSolver(const RefinementBasis& functions, int slots);

}  // namespace hpdm
