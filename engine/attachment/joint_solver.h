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
/// Copies continue to the last bit. Deformation thread; allocates nothing after its construction.
class JointSolver {
 public:
  explicit JointSolver(std::shared_ptr<const AttachmentJoint> joint);

  /// Returns zeros for a layer's stiffness (s x s, N/m, the same along each axis), of which the lower
  /// triangle is to be filled. TakeLayer() takes it.
  Eigen::Ref<Eigen::MatrixXd> RoomFor(std::size_t layer);
  /// Makes 3s x 3s of what has been filled, for parts that differ between the axes.
  void SpreadOverAxes(std::size_t layer);
  /// Returns the room in its present size.
  Eigen::Ref<Eigen::MatrixXd> RoomOf(std::size_t layer);
  void TakeLayer(std::size_t layer);
  /// Follows TakeLayer() of all layers; needed once without layers, too.
  void FactorLayers();
  /// Takes the ducts' stiffness. A duct under pressure can have a negative one: if the organs cannot
  /// hold it, that part is left out (DuctState::Stabilise).
  void TakeDucts(std::span<DuctState> ducts);

  /// Returns a layer's stiffness as it was taken, 3s x 3s. Allocates; set-up only.
  Eigen::MatrixXd StiffnessOf(std::size_t layer) const;

  /// Computes [y; w_d] of the columns w_0 (3r x k) in the first rows of `half` (3r x k), zeros below.
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

  /// C of a layer in its rows. `axes`: 1, or 3 if C is the same along each.
  struct Root {
    Eigen::MatrixXd stiffness;  // as filled
    RowMajorMatrix columns, transposed;
    Eigen::Index size = 0, rank = 0;
    int axes = 1;
    Eigen::Index first = 0;  // column of C
    bool changed = true;     // its rows of product_ are to be computed
    Eigen::Index columns_of_C() const { return axes * rank; }
  };

  void MultiplyRoots(const Eigen::Ref<const FewColumns>& X, Eigen::Ref<FewColumns> Y,
                     Eigen::Index rows, bool changed_only = false) const;
  void CondenseLayers();
  void BeginSolution(const Eigen::Ref<const FewColumns>& w_0) const;
  void EndSolution(Eigen::Ref<FewColumns> q) const;
  void SetRootForces(const Eigen::Ref<const FewColumns>& z, Eigen::Ref<FewColumns> q) const;

  std::shared_ptr<const AttachmentJoint> joint_;
  Eigen::Index unknowns_, duct_unknowns_;  // 3r, and those of the ducts, which come last
  std::vector<Root> roots_;
  Eigen::Index rank_ = 0;                                    // columns of C
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
