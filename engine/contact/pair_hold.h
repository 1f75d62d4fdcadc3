#pragma once

#include <array>
#include <span>
#include <vector>

#include "engine/base/copying.h"
#include "engine/contact/contact_solver.h"
#include "engine/contact/lattice_compliance.h"

namespace hpdm {

/// The contacts between organs that carry force after a solve, for small changes of the other
/// loads: those that press stay closed, those that stick stay tied, and the friction of those that
/// slide stays in proportion. Sized once; deformation thread; allocates nothing.
class PairHold {
 public:
  /// One body's part in an equation that holds.
  struct Side {
    int place = 0;                        ///< Number of the equation among those that hold.
    int row = 0;                          ///< Of the body's constraints.
    Vector3d axis_W = Vector3d::Zero();   ///< Axis of the equation.
    Vector3d force_W = Vector3d::Zero();  ///< Force on the body for f = 1, with its friction.
  };

  PairHold();
  void Clear() { size_ = 0; }
  /// Takes the pairs' equations that hold in a solved problem.
  void Take(const ContactSolver& solver);

  int size() const { return size_; }
  /// The parts of body number `body` of the problem.
  std::span<const Side> sides(int body) const;
  /// A^-1 of the equations that hold, N/m; not symmetric while one slides.
  auto stiffness() const { return stiffness_.topLeftCorner(size_, size_); }

 private:
  int size_ = 0;
  std::vector<Side> sides_;  // 2 kMaxEquations
  std::vector<std::size_t> first_side_;
  WorkMatrix compliance_, stiffness_;  // kMaxEquations x kMaxEquations
};

/// The response of an organ to small loads while its contacts with other organs hold,
///     K^-1 b^T - K^-1 B^T A^-1 B K^-1 b^T
/// with the rows B of the contacts that hold and their compliance A over all organs. The others
/// move too. Deformation thread; allocates nothing.
class HeldCompliance final : public LatticeCompliance {
 public:
  /// Computes K^-1 B^T. `free`: K^-1; `contacts`: of the organ, which was number `body`; `scratch`: at
  /// least 3 (n + slots) x ContactSolver::kMaxEquations. All must outlive it.
  HeldCompliance(const LatticeCompliance& free, const ContactConstraints& contacts,
                 const PairHold& hold, int body, Eigen::MatrixXd* scratch);

  void RespondTo(const SparseRow& b, Eigen::Ref<Eigen::MatrixXd> response) const override;
  Matrix3d PointCompliance(const SparseRow& b) const override { return free_.PointCompliance(b); }
  void SolveLoads(Eigen::Ref<Eigen::MatrixXd> loads) const override { free_.SolveLoads(loads); }

 private:
  const LatticeCompliance& free_;
  const ContactConstraints& contacts_;
  const PairHold& hold_;
  int body_;
  Eigen::MatrixXd* scratch_;  // its first columns: the response to each side's force
};

}  // namespace hpdm
