#pragma once

#include <array>

#include "engine/contact/contact_constraints.h"

namespace hpdm {

/// How a relaxation ended.
struct RelaxationResult {
  int iterations = 0;        ///< Number of sweeps (Gauss-Seidel), Newton steps or active-set
                             ///< changes.
  double residual = 0;       ///< |gradient of the energy - B^T f| / |B^T f|, or 0 without force.
  bool converged = true;     ///< False if the iterations were used up first.
  bool regularised = false;  ///< Contacts (nearly) coincide and share their force.
  bool out_of_time = false;  ///< The clock ended the iterations before convergence.
  /// Derivative of the energy by the share of finite strain, over the energy
  /// (BlendedEnergy::ShareSlope); 0 if that share is 0.
  double share_slope = 0;
};

/// Solves the contacts of one step in their compliance space. Each of the E scalar equations is for
/// one contact point along one axis. The compliance A (E x E, m/N) couples them:
///     grasp:   A f = change
///     press:   f >= 0,   A f >= change,   f (A f - change) = 0.
///
/// 1. A grasp row gives three equations along the world axes.
/// 2. A press row gives one along minus its normal, with f the pressing force f_n and `change` the
///    depth of the tool below the point. With friction its force is not along its axis, and A is
///    not symmetric.
/// 3. The local compliance of a row (ContactConstraints::Row) is added to its point's own block of
///    A, that between coupled rows to their common blocks. Under a tip it depends on the pressing
///    force (LocalIndentation): Newton's method starts without force, from where it increases, and
///    each of its rounds solves the equations above.
/// 4. (Nearly) coincident contacts with different targets would pull against each other with up to
///    1e9 times the force of one alone. If forces exceed kContradicting times the single-contact
///    force, slip compliance is added until they are below kSlipping times it
///    (ContactConstraints::Row::slip).
///
/// The method is an active set. Sized once; deformation thread; allocates nothing.
class ContactSolver {
 public:
  /// Forces above this multiple of the single-contact force count as contradicting. That force is
  /// the longest demanded displacement times the stiffness of the stiffest contact. A grasp that
  /// twists its tissue reaches a multiple of 100, two tools that cross reach 500.
  static constexpr double kContradicting = 1000;
  static constexpr double kSlipping = 10;
  static constexpr int kMaxEquations = 3 * kMaxContacts;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor,
                               kMaxEquations, kMaxEquations>;
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxEquations, 1>;
  struct Equation {
    int row = 0;                          ///< Index of the contact constraint.
    Vector3d axis_W = Vector3d::Zero();   ///< Axis along which the point moves.
    Vector3d force_W = Vector3d::Zero();  ///< Force on the tissue for f = 1.
    bool unilateral = false;
  };

  /// Lists the equations of `contacts`. change() is the distance of each target from the point's
  /// rest position along the axis.
  void Build(const ContactConstraints& contacts);

  int size() const { return size_; }
  const Equation& operator[](int e) const { return equations_[e]; }
  /// The contact compliance A (E x E) of the lattice alone. The caller fills it before each
  /// Solve().
  Matrix& compliance() { return compliance_; }
  Vector& change() { return change_; }              ///< E, m.
  const Vector& forces() const { return forces_; }  ///< E, N; result of Solve().

  /// Adds the local compliance and computes the forces. The rounds are bounded; a cycle ends with
  /// the last forces and converged = false. The contacts of Build() must not have changed.
  RelaxationResult Solve();

  /// Sets the rows' forces on the tissue and their slip.
  void WriteForces(ContactConstraints* contacts) const;

 private:
  // A tip's local law, f (along q(f)), about the last round's forces.
  struct TipLaw {
    const LocalIndentation* indentation = nullptr;  // nullptr: none
    double along = 0;                               // m^2/N
    double compliance = 0;                          // m/N, without the law
    double change = 0;                              // m, without the law
  };

  void AddLocalCompliance();
  void LineariseTipLaws();
  void SolveLinear(RelaxationResult* result);
  bool SolveActive();
  bool HasFriction() const;
  bool UpdateActiveSet();

  int size_ = 0;
  std::array<Equation, kMaxEquations> equations_;
  std::array<Vector3d, kMaxEquations> local_;  // local compliance times force
  std::array<TipLaw, kMaxEquations> tip_laws_;
  bool has_tip_law_ = false;
  std::array<CoupledRow, kMaxEquations> coupled_;
  std::array<bool, kMaxEquations> active_{};
  std::array<int, kMaxEquations> active_list_{};
  Matrix compliance_;
  Matrix active_compliance_;
  Vector change_;
  Vector active_forces_;
  Vector forces_;
  double slip_ = 0;  // m/N
};

}  // namespace hpdm
