#pragma once

#include "engine/attachment/attachment_state.h"
#include "engine/contact/lattice_compliance.h"

namespace hpdm {

/// The response of an organ to small loads while the layers hold it with their present damage:
///     H b^T - H Phi^T (1 + R G)^-1 R Phi H b^T.
/// The other organs of the joint move too. Deformation thread; only its construction allocates.
class AttachedCompliance final : public LatticeCompliance {
 public:
  /// `free`: H of the organ; `member`: its number in the joint; `state` and `work` (each 3r x 3)
  /// must outlive it, as `free` must.
  struct Work {
    explicit Work(Eigen::Index unknowns = 0) : w(unknowns, 3), settled(unknowns), q(unknowns) {}
    Eigen::MatrixXd w;        // 3r x 3
    Eigen::VectorXd settled;  // 3r
    Eigen::VectorXd q;        // 3r
  };
  AttachedCompliance(const LatticeCompliance& free, const AttachmentState& state, int member,
                     Work* work)
      : free_(free),
        state_(state),
        member_(state.joint().members()[static_cast<std::size_t>(member)]),
        work_(*work) {}

  void RespondTo(const SparseRow& b, Eigen::Ref<Eigen::MatrixXd> response) const override;
  void SolveLoads(Eigen::Ref<Eigen::MatrixXd> loads) const override;
  void AddLocalPart(const Eigen::Ref<const Eigen::VectorXd>& V,
                    Eigen::Ref<Eigen::VectorXd> U_bar) const override {
    free_.AddLocalPart(V, U_bar);
  }
  Matrix3d PointCompliance(const SparseRow& b) const override;

 private:
  /// Sets w to the modes' displacements by unit forces on the point of row b, without the layers.
  void LoadModes(const SparseRow& b) const;
  /// Sets q to the layers' forces on the modes, which would be displaced by `moved` without them.
  void FindForces(Eigen::Ref<const Eigen::VectorXd> moved) const;

  const LatticeCompliance& free_;
  const AttachmentState& state_;
  const AttachmentJoint::Member& member_;
  Work& work_;
};

}  // namespace hpdm
