#pragma once

#include <memory>

#include "engine/contact/contact_solver.h"
#include "engine/contact/lattice_compliance.h"
#include "engine/energy/metric_energy.h"
#include "engine/energy/strain_energy.h"
#include "engine/solver/refinement_basis.h"

namespace hpdm {

/// The compliance between the equations of `contact_solver` (built from `contacts`) from the
/// response to a unit force along each: A_eg = axis_e . (b_e U_g), with column g of `response` (3n
/// x >= E) the displacements U_g.
void FillCompliance(const ContactConstraints& contacts,
                    const Eigen::Ref<const Eigen::MatrixXd>& response,
                    ContactSolver* contact_solver);

/// What a lattice of constant stiffness K answers to loads: U = K^-1 R, with K factorised once.
/// Owned by one thread; Respond() and Deform() allocate nothing.
class ComplianceSolver : public LatticeCompliance {
 public:
  /// Takes the local functions in use; Respond() does the same with those of its contacts. Without
  /// local functions nothing.
  virtual void SetActiveFunctions(const ActiveRefinement& active) { static_cast<void>(active); }

  /// The compliance A = B_c K^-1 B_c^T of `contact_solver` (built from `contacts`); what Deform()
  /// needs of the contacts is kept.
  virtual void Respond(const ContactConstraints& contacts, ContactSolver* contact_solver) = 0;

  /// U (n x 3, m; with local functions their slots follow) under the contact solver's forces; of
  /// the last Respond().
  virtual void Deform(const ContactSolver& contact_solver, Points* U) const = 0;

  /// R -> K^-1 R in place: columns of 3n loads (N), of control point a along d in row 3 a + d.
  virtual void Solve(Eigen::Ref<Eigen::MatrixXd> columns) const = 0;
};

/// Where a lattice of constant stiffness comes to rest under `contacts`: their forces, and U (n x
/// 3, m). `contact_solver` is scratch, with which the response is asked again.
RelaxationResult SolveContacts(ComplianceSolver* compliance_solver, ContactSolver* contact_solver,
                               ContactConstraints* contacts, Points* U);

/// K^-1. A contact's row b has few entries, one for each function that is not zero there (27 of
/// quadratic splines), so a product with the columns of K^-1 that they name is several times
/// cheaper than two triangular solves. Throws InputError (`remedy`) when K is not positive
/// definite, or to round-off only.
Eigen::MatrixXd InverseStiffness(const Eigen::Ref<const Eigen::MatrixXd>& K, const char* remedy);

/// Of dense K^-1. Throw InputError when K is not positive definite.
std::unique_ptr<ComplianceSolver> MakeComplianceSolver(const ScalarStiffness& K);
std::unique_ptr<ComplianceSolver> MakeComplianceSolver(const FullStiffness& K);

/// With local functions in at most `slots` slots (enriched_compliance_solver.h). `functions` must
/// outlive it.
std::unique_ptr<ComplianceSolver> MakeComplianceSolver(const RefinementBasis& functions, int slots);

}  // namespace hpdm
