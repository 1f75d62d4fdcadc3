#pragma once

#include <span>
#include <vector>

#include "engine/attachment/attachment_state.h"
#include "engine/contact/lattice_compliance.h"

namespace hpdm {

/// The response of an organ to small loads while the layers and ducts hold it with their present
/// stiffness R:
///     H b^T - H Phi^T R (1 + G R)^-1 Phi H b^T.
/// The other organs of the joint move too. The second term is the other part of a set of rows:
/// H Phi^T is applied only to combinations of the rows. Deformation thread; allocates nothing.
class AttachedCompliance final : public LatticeCompliance {
 public:
  /// Working memory for a set of rows, which has three columns for each row. It serves all organs.
  struct Work {
    /// Makes room for a joint's organs and a set of that many columns, at least 3. Allocates.
    void MakeRoom(const AttachmentJoint& joint, Eigen::Index columns = 3);

    Eigen::MatrixXd w_0;                // 3r x columns: Phi H b^T
    Eigen::MatrixXd half, half_forces;  // JointSolver::Halve of it, and with its ducts' forces
    FewColumns few_w;                   // 3r rows
    std::vector<FewColumns> few_q;      // the same, for all columns in groups of kFewColumns
    FewColumns moved;                   // kRowsTogether rows
  };
  /// `free`: H of the organ; `member`: its number in the joint. All must outlive this. `R_WF`: the
  /// member's frame once its layers have let it go.
  AttachedCompliance(const LatticeCompliance& free, const AttachmentState& state, int member,
                     Work* work, const Matrix3d& R_WF = Matrix3d::Identity())
      : free_(free),
        state_(state),
        member_(state.joint().members()[static_cast<std::size_t>(member)]),
        unknowns_(3 * state.joint().modes()),
        work_(*work),
        R_WF_(R_WF),
        turned_(R_WF != Matrix3d::Identity()) {}

  void RespondTo(const SparseRow& b, Eigen::Ref<Eigen::MatrixXd> response) const override;
  void RespondInPart(std::span<const SparseRow> rows,
                     Eigen::Ref<Eigen::MatrixXd> responses) const override;
  void AddOtherPart(Eigen::Ref<Eigen::MatrixXd> compliance) const override;
  void AddOtherPart(const Eigen::Ref<const Eigen::MatrixXd>& forces,
                    Eigen::Ref<Eigen::MatrixXd> responses) const override;
  void SolveLoads(Eigen::Ref<Eigen::MatrixXd> loads) const override;
  void AddLocalPart(const Eigen::Ref<const Eigen::VectorXd>& V,
                    Eigen::Ref<Eigen::VectorXd> U_bar) const override {
    free_.AddLocalPart(V, U_bar);
  }
  Matrix3d PointCompliance(const SparseRow& b) const override;

 private:
  /// Rows of a member's response that stay in the cache for all groups of columns; a multiple of 3.
  static constexpr Eigen::Index kRowsTogether = 96;

  /// Fills the columns of row number i of a set.
  void LoadModes(int i, const SparseRow& b) const;
  /// Fills few_w with Phi of the responses to at most kFewColumns loads, without layers.
  void LoadModes(const Eigen::Ref<const Eigen::MatrixXd>& loads) const;
  /// Finds the forces of layers and ducts for a group of kFewColumns responses, given Phi of the
  /// responses without them in few_w.
  void FindForces(Eigen::Index group) const;
  /// Takes what layers and ducts do from the responses, given their forces.
  void TakeLayers(Eigen::Ref<Eigen::MatrixXd> responses) const;

  const LatticeCompliance& free_;
  const AttachmentState& state_;
  const AttachmentJoint::Member& member_;
  Eigen::Index unknowns_;  // 3r; the work may be larger
  Work& work_;
  Matrix3d R_WF_;
  bool turned_;
};

}  // namespace hpdm
