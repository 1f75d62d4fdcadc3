#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <memory>
#include <span>
#include <vector>

#include "engine/attachment/attachment_joint.h"
#include "engine/base/copying.h"
#include "engine/base/few_columns.h"
#include "engine/duct/duct_state.h"

namespace hpdm {

/// Solves for the forces of a joint's layers and ducts with their present stiffness R. With the modes'
/// displacements w_0 without them,
///     q = R (1 + G R)^-1 w_0,   w = w_0 - G q.
///
/// A layer's block of R is C C^T, so that with
///     B = 1 + C^T G C = L L^T,   y = L^-1 C^T w_0
/// the layers alone have the forces q = C L^-T y, and y . y is w_0 . q. No eigenvalue of B is below 1,
/// however nearly the modes depend on each other, and a layer that is torn has no columns in C. Ducts
/// come second, since their stiffness changes in every step and may have negative parts. In their
/// modes d, with the layers in place,
///     w_d = w_0d - W y,   W = G_d C L^-T,   S = G_dd - W W^T,   q_d = T w_d,   T = R_d (1 + S R_d)^-1.
///
/// Most samples respond alike along all axes, so one root serves all three. Those that respond along
/// one direction alone, or more stiffly there, have a column of C each. These come last: where samples
/// only open or close, L keeps the rows above them. The result does not depend on which rows were kept,
/// to the last bit.
///
/// Copies continue to the last bit. Deformation thread; allocates nothing after its construction.
class JointSolver {
 public:
  explicit JointSolver(std::shared_ptr<const AttachmentJoint> joint);

  /// Returns zeros for a layer's stiffness (s x s, N/m, the same along each axis), of which the lower
  /// triangle is to be filled. TakeAlike() takes it.
  Eigen::Ref<Eigen::MatrixXd> RoomFor(std::size_t layer);
  void TakeAlike(std::size_t layer);
  /// Removes what AddBeside() has added to a layer.
  void ClearBeside(std::size_t layer);
  /// Adds the stiffness (m v)(m v)^T of a sample with the modes m (s) that responds along v (sqrt(N/m)).
  void AddBeside(std::size_t layer, const Eigen::Ref<const Eigen::VectorXd>& m, const Vector3d& v);
  /// Follows TakeAlike() and AddBeside() of all layers; needed once without layers, too.
  void FactorLayers();
  /// Takes the ducts' stiffness. A duct under pressure can have a negative one: if the organs cannot
  /// hold it, that part is left out (DuctState::Stabilise).
  void TakeDucts(std::span<DuctState> ducts);

  /// Returns a layer's stiffness without what is beside, 3s x 3s. Allocates; set-up only.
  Eigen::MatrixXd StiffnessOf(std::size_t layer) const;

  /// Returns the present number of entries of [y; w_d].
  Eigen::Index half_size() const { return rank_ + duct_unknowns_; }
  /// Returns the most that there can be.
  static Eigen::Index MostHalfSize(const AttachmentJoint& joint);
  /// Computes [y; w_d] of the columns w_0 (3r x k) in `half` (half_size() x k).
  void Halve(const Eigen::Ref<const Eigen::MatrixXd>& w_0, Eigen::Ref<Eigen::MatrixXd> half) const;
  /// Replaces [y; w_d] by [y; T w_d]: its product with another column's [y; w_d] is w_0 . q of both.
  void TakeDuctForces(Eigen::Ref<Eigen::MatrixXd> half) const;

  /// Computes q (3r x 8) of w_0 (3r x 8).
  void FindForces(const Eigen::Ref<const FewColumns>& w_0, Eigen::Ref<FewColumns> q) const;
  /// Computes q (3r) of w_0. The ducts' part of w is solved for, so q is R w there to the last digits.
  void FindForces(const Eigen::VectorXd& w_0, Eigen::VectorXd* q) const;
  /// The same with w. Where soft organs would move far and layers hold them, w is a small difference of
  /// w_0 and G q: a step of iterative refinement keeps its digits.
  void FindForces(const Eigen::VectorXd& w_0, Eigen::VectorXd* q, Eigen::VectorXd* w) const;

 private:
  void Refine(Eigen::VectorXd* q, Eigen::VectorXd* w) const;

  /// A part of C in the rows of a layer. `axes`: 1, or 3 if it is the same along each.
  struct Root {
    Root(Eigen::Index first_row, Eigen::Index size, Eigen::Index most, int axes)
        : columns(RowMajorMatrix::Zero(size, most)),
          transposed(RowMajorMatrix::Zero(most, size)),
          axes(axes),
          first_row(first_row) {}
    Eigen::Index columns_of_C() const { return axes * rank; }

    RowMajorMatrix columns, transposed;  // the first `rank` are used
    Eigen::Index rank = 0;
    int axes;
    Eigen::Index first_row;  // of C
    Eigen::Index first = 0;  // column of C
    bool changed = true;     // since FactorLayers()
  };

  void MultiplyRoots(const Eigen::Ref<const FewColumns>& X, Eigen::Ref<FewColumns> Y,
                     Eigen::Index rows, bool changed_only = false) const;
  void CondenseLayers();
  void BeginSolution(const Eigen::Ref<const FewColumns>& w_0) const;
  void EndSolution(Eigen::Ref<FewColumns> q) const;
  void SetRootForces(const Eigen::Ref<const FewColumns>& z, Eigen::Ref<FewColumns> q) const;

  Root& Alike(std::size_t layer) { return roots_[layer]; }
  Root& Beside(std::size_t layer) { return roots_[stiffness_.size() + layer]; }

  std::shared_ptr<const AttachmentJoint> joint_;
  Eigen::Index unknowns_, duct_unknowns_;   // 3r, and those of the ducts, which come last
  std::vector<Eigen::MatrixXd> stiffness_;  // of each layer, along each axis, as filled
  std::vector<Root> roots_;  // of what is alike, and then of what is beside, of all layers
  Eigen::Index most_rank_, rank_ = 0;                        // columns of C
  Eigen::MatrixXd factor_;                                   // L in its corner
  Eigen::MatrixXd duct_rows_;                                // rank x ducts: W^T
  Eigen::MatrixXd duct_compliance_, duct_root_;              // S, and a root of it
  Eigen::MatrixXd duct_stiffness_;                           // R_d
  Eigen::PartialPivLU<Eigen::MatrixXd> duct_factor_;         // of 1 + S R_d
  Eigen::MatrixXd duct_forces_;                              // T
  RowMajorMatrix product_;                                   // C^T G
  WorkMatrixOf<RowMajorMatrix> transposed_;                  // G C of the layers' modes
  mutable WorkMatrixOf<FewColumns> y_, w_, one_, q_, step_;  // scratch
  mutable Eigen::VectorXd moved_;                            // of the ducts' modes, scratch
  WorkMatrix duct_work_, duct_inner_;
  WorkMatrix root_;
  WorkMatrixOf<Eigen::VectorXd> rest_;
};

}  // namespace hpdm
