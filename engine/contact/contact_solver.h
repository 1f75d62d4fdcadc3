#pragma once

#include <array>

#include "engine/contact/contact_constraints.h"

namespace hpdm {

/// How a relaxation ended.
struct RelaxationResult {
  int iterations = 0;        ///< Sweeps (Gauss-Seidel), Newton steps, or changes of the active set.
  double residual = 0;       ///< |gradient of the energy - B^T f| / |B^T f|, or 0 without force.
  bool converged = true;     ///< False when the iteration budget was spent first.
  bool regularised = false;  ///< Contacts (nearly) coincide and share their force.
  bool out_of_time = false;  ///< Not converged because its clock said so.
  /// Relative change of the energy, in which contacts do no work, by the share of finite strain in
  /// it (BlendedEnergy::ShareSlope); 0 where that share is 0.
  double share_slope = 0;
};

/// The contacts of one step in their compliance space: E scalar equations, of which each moves one
/// contact point along one axis, coupled by the compliance A (E x E, m/N),
///     A f = change                                  where a contact is held (grasp),
///     0 <= f, A f >= change, f (A f - change) = 0   where it presses.
/// A grasp row gives three equations along the world axes; a press one, along minus its normal,
/// with f the pressing force f_n and `change` how deep the tool is below the point. With
/// friction a press's force is not along its axis, and A is not symmetric.
/// The rows' local compliance (ContactConstraints::Row) adds to their points' own blocks of A.
/// Solved by an active-set method. Sized once; deformation thread; allocates nothing.
///
/// (Nearly) coincident contacts that are to go different ways would pull against each other with up
/// to a billion times what either takes alone: beyond kContradicting times they slip, with as much
/// compliance between tool and tissue as leaves them kSlipping times
/// (ContactConstraints::Row::slip).
class ContactSolver {
 public:
  /// The points of a grasp that twists its tissue pull against each other with a hundred times what
  /// the longest way takes at the stiffest contact alone, two tools that cross with five hundred.
  static constexpr double kContradicting = 1000;
  static constexpr double kSlipping = 10;
  static constexpr int kMaxEquations = 3 * kMaxContacts;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor,
                               kMaxEquations, kMaxEquations>;
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxEquations, 1>;
  struct Equation {
    int row = 0;                          ///< Of the contact constraints.
    Vector3d axis_W = Vector3d::Zero();   ///< Along which the point moves.
    Vector3d force_W = Vector3d::Zero();  ///< On the tissue, of f = 1.
    bool unilateral = false;
  };

  /// Lists the equations of `contacts`; `change` is how far each target lies from the point's rest
  /// position along the axis.
  void Build(const ContactConstraints& contacts);

  int size() const { return size_; }
  const Equation& operator[](int e) const { return equations_[e]; }
  /// A (E x E), of the lattice alone, to be filled in before each Solve().
  Matrix& compliance() { return compliance_; }
  Vector& change() { return change_; }              ///< E, m.
  const Vector& forces() const { return forces_; }  ///< E, N, of Solve().

  /// Adds the local compliance and sets the forces. The rounds are bounded; a cycle keeps the last
  /// forces, not converged.
  RelaxationResult Solve();

  /// The rows' forces on the tissue, sum of forces times axes, and their slip.
  void WriteForces(ContactConstraints* contacts) const;

 private:
  void AddLocalCompliance();
  bool SolveActive();
  bool HasFriction() const;
  bool UpdateActiveSet();

  int size_ = 0;
  std::array<Equation, kMaxEquations> equations_;
  std::array<Vector3d, kMaxEquations> local_;  // C_loc force
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
