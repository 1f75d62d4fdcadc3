#pragma once

#include <array>
#include <span>
#include <vector>

#include "engine/base/copying.h"
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
  /// (BlendedEnergy::ShareSlope); 0, unknown, if that share is 0 or 1.
  double share_slope = 0;
};

/// Solves the contacts of one step in their compliance space, those of one organ or of several that
/// touch each other: the bodies. Each of the E scalar equations is for one contact along one axis.
/// The compliance A (E x E, m/N) couples them:
///     grasp:   A f = change
///     press:   f >= 0,   A f >= change,   f (A f - change) = 0
///     pair:    as a press, and Coulomb friction across it.
///
/// 1. A grasp row gives three equations along the world axes.
/// 2. A press row gives one along minus its normal, with f the pressing force f_n and `change` the
///    depth of the tool below the point. With friction its force is not along its axis, and A is
///    not symmetric.
/// 3. A pair (OrganContact) gives one along its normal. With friction two follow across it. Their
///    forces are found in turn with all others: Gauss-Seidel sweeps move them against the slip and
///    bound them by the friction, the rest is solved again, until the forces change no more.
/// 4. The local compliance of a row (ContactConstraints::Row) is added to its point's own block of
///    A, that between coupled rows to their common blocks. Under a tip it depends on the pressing
///    force (LocalIndentation): Newton's method starts without force, from where it increases, and
///    each of its rounds solves the equations above.
/// 5. (Nearly) coincident contacts of tools with different targets would pull against each other
///    with up to 1e9 times the force of one alone. If the tools' forces exceed kContradicting times
///    the single-contact force, slip compliance is added until they are below kSlipping times it
///    (ContactConstraints::Row::slip).
///
/// The method is an active set that changes all wrong contacts at once. If that does not lead to
/// fewer of them, it changes one at a time, which ends for every positive definite A (Murty 1974).
/// Sized once; deformation thread; allocates nothing.
class ContactSolver {
 public:
  /// Forces above this multiple of the single-contact force count as contradicting. That force is
  /// the longest demanded displacement times the stiffness of the stiffest contact. A grasp that
  /// twists its tissue reaches a multiple of 100, two tools that cross reach 500.
  static constexpr double kContradicting = 1000;
  static constexpr double kSlipping = 10;
  static constexpr int kMaxEquations = 3 * kMaxContacts;
  static constexpr int kMaxBodies = 64;
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxEquations, 1>;
  /// One body's part in an equation. A pair's equations have a part in both bodies.
  struct Side {
    int equation = 0;
    int row = 0;                          ///< Of the body's constraints.
    Vector3d axis_W = Vector3d::Zero();   ///< Axis along which the point moves.
    Vector3d force_W = Vector3d::Zero();  ///< Force on the body for f = 1.
  };

  ContactSolver();

  /// Lists the equations of the bodies' rows, then those of `pairs` until kMaxEquations. change()
  /// is the distance of each target from the point's rest position along the axis. At most
  /// kMaxBodies bodies.
  void Build(std::span<const ContactConstraints* const> bodies,
             std::span<const OrganContact> pairs);
  void Build(const ContactConstraints& contacts) {
    const std::array<const ContactConstraints*, 1> alone{&contacts};
    Build(alone, {});
  }

  /// Replaces the axes and forces a of the body's parts by `rotation` a, for a body that computes
  /// its part of the compliance in a frame of its own. It turns them back.
  void Turn(int body, const Matrix3d& rotation) {
    const auto b = static_cast<std::size_t>(body);
    for (std::size_t s = first_side_[b]; s < first_side_[b + 1]; ++s) {
      sides_[s].axis_W = rotation * sides_[s].axis_W;
      sides_[s].force_W = rotation * sides_[s].force_W;
    }
  }

  int size() const { return size_; }
  /// The parts of one body, those of one row next to each other. With a body alone and no pairs,
  /// part e is of equation e.
  std::span<const Side> sides(int body = 0) const {
    const auto b = static_cast<std::size_t>(body);
    return {sides_.data() + first_side_[b], first_side_[b + 1] - first_side_[b]};
  }
  /// The contact compliance A (E x E) of the organs alone. Build() clears it; the caller adds each
  /// body's part before Solve().
  auto compliance() { return compliance_.topLeftCorner(size_, size_); }
  /// Adds yield `relaxed` to A_eg. `relaxed`, m/N: that of the organ after relaxation.
  void AddCompliance(int e, int g, double relaxed, double yield) {
    compliance_(e, g) += yield * relaxed;
    relaxed_(e, g) += relaxed;
  }
  Vector& change() { return change_; }              ///< E, m.
  const Vector& forces() const { return forces_; }  ///< E, N; result of Solve().

  /// Adds the local compliance and computes the forces. The rounds are bounded; a cycle ends with
  /// the last forces and converged = false. The contacts of Build() must not have changed.
  RelaxationResult Solve();

  /// Keeps the problem as it is before Solve(), and returns to it: another one follows with the same
  /// contacts and bodies.
  void Keep();
  void TakeBack();

  /// Returns the forces of sides(body), N.
  Vector ForcesOn(int body) const;
  /// Sets the forces on a body's rows and their slip.
  void WriteForces(int body, ContactConstraints* contacts) const;
  void WriteForces(ContactConstraints* contacts) const { WriteForces(0, contacts); }
  /// Sets the pairs' pressing forces; `pairs`: those of Build().
  void WriteForces(std::span<OrganContact> pairs) const;

  // After Solve(), for the pairs' equations, which follow the first_pair_equation() others:
  int bodies() const { return bodies_; }
  int first_pair_equation() const { return first_pair_equation_; }
  /// True if the equation holds: the contact presses or, across it, sticks.
  bool IsActive(int equation) const;
  /// Returns the displacement (m/N) of equation e for a unit force of g after relaxation, with the
  /// friction of a pair that slides.
  double WithFriction(int e, int g) const;
  /// Returns the force on the side's body for f = 1, with that friction.
  Vector3d ForceWithFriction(const Side& side) const;

 private:
  // A part of one of the matrices; temporaries have a fixed largest size.
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor,
                               kMaxEquations, kMaxEquations>;

  // A tip's local law, f (along q(f)), about the last round's forces.
  struct TipLaw {
    const LocalIndentation* indentation = nullptr;  // nullptr: none
    double along = 0;                               // m^2/N
    double compliance = 0;                          // m/N, without the law
    double change = 0;                              // m, without the law
  };
  struct Equation {
    const ContactConstraints::Row* row = nullptr;  // nullptr: a pair's
    Vector3d axis_W = Vector3d::Zero();
    Vector3d force_W = Vector3d::Zero();
    Vector3d local_W = Vector3d::Zero();  // local compliance times force, m/N
    bool unilateral = false;
    bool across = false;  // across a pair: the equation along its normal stands before
    double friction = 0;  // along a pair's normal: coefficient, 0 without equations across
    TipLaw tip_law = {};
  };

  void AddOwnEquations(const ContactConstraints& contacts);
  void AddPairEquations(std::span<const OrganContact> pairs);
  void ListSides(std::span<const ContactConstraints* const> bodies,
                 std::span<const OrganContact> pairs);
  void AddLocalCompliance();
  void LineariseTipLaws();
  void SolveLinear(RelaxationResult* result);
  bool SolveActive();
  bool HasFriction() const;
  bool SolveNormals(RelaxationResult* result);
  int UpdateActiveSet(bool one_at_a_time);
  bool IsWrong(int e, double slack) const;
  double UpdateFriction();
  bool Slides(int e) const;

  int size_ = 0;
  int bodies_ = 0;
  int first_pair_equation_ = 0;
  std::vector<Equation> equations_;  // kMaxEquations
  std::vector<Side> sides_;          // 2 kMaxEquations
  std::array<std::size_t, kMaxBodies + 1> first_side_{};
  std::array<int, kMaxContacts> pair_equation_{};  // of each pair
  int pair_count_ = 0;
  bool has_tip_law_ = false;
  bool has_pair_friction_ = false;
  std::array<bool, kMaxEquations> active_{};
  std::array<int, kMaxEquations> active_list_{};
  WorkMatrix compliance_;         // kMaxEquations x kMaxEquations
  WorkMatrix relaxed_;            // the same after relaxation, without local compliance
  WorkMatrix active_compliance_;  // the same
  WorkMatrix kept_compliance_, kept_relaxed_;
  Vector change_, kept_change_;
  Vector active_forces_;
  Vector loads_;  // E, m: displacements by the forces across the pairs
  Vector forces_;
  double slip_ = 0;  // m/N
};

}  // namespace hpdm
