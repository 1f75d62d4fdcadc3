#pragma once

#include <memory>

#include "engine/contact/contact_solver.h"
#include "engine/contact/lattice_compliance.h"
#include "engine/energy/metric_energy.h"
#include "engine/energy/strain_energy.h"
#include "engine/solver/refinement_basis.h"

namespace hpdm {

/// Computes the compliance between the equations of `contact_solver` (built from `contacts`),
///     A_eg = axis_e . (b_e U_g)
/// with column g of `response` (3n x >= E) the displacements U_g for a unit force of equation g.
void FillCompliance(const ContactConstraints& contacts,
                    const Eigen::Ref<const Eigen::MatrixXd>& response,
                    ContactSolver* contact_solver);

/// The response U = K^-1 R of a lattice of constant stiffness K to loads R, with K inverted once.
/// Owned by one thread; Respond() and Deform() allocate nothing.
class ComplianceSolver : public LatticeCompliance {
 public:
  /// Sets the local functions in use; Respond() does the same with those of its contacts. Does
  /// nothing if the solver has no local functions.
  virtual void SetActiveFunctions(const ActiveRefinement& active) { static_cast<void>(active); }

  /// Computes the compliance A = B_c K^-1 B_c^T of `contact_solver` (built from `contacts`). Keeps
  /// the data of the contacts that Deform() needs.
  virtual void Respond(const ContactConstraints& contacts, ContactSolver* contact_solver) = 0;

  /// Computes U (n x 3, m; with local functions their slots follow) under the forces of
  /// `contact_solver`, which the last Respond() saw.
  virtual void Deform(const ContactSolver& contact_solver, Points* U) const = 0;

  /// Replaces R by K^-1 R: columns of 3n loads (N); row 3 a + d is control point a along d.
  virtual void Solve(Eigen::Ref<Eigen::MatrixXd> columns) const = 0;
};

/// Solves a lattice of constant stiffness under `contacts`: computes their forces and U (n x 3, m).
/// `contact_solver` is scratch space.
RelaxationResult SolveContacts(ComplianceSolver* compliance_solver, ContactSolver* contact_solver,
                               ContactConstraints* contacts, Points* U);

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
