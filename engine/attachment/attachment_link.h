#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "engine/attachment/attachment_state.h"
#include "engine/base/copying.h"
#include "engine/scene_limits.h"
#include "engine/solver/contact_body.h"

namespace hpdm {

/// The layers of one joint in a step's contact problem. A step solves the problem with the present
/// damage, lets the damage grow with the displacements found, and solves again, at most kMaxRounds
/// times; the last growth counts in the next step. Deformation thread; allocates nothing.
class AttachmentLink final : public BodyLink {
 public:
  static constexpr int kMaxRounds = 4;
  /// The same while ducts hold an organ that has been let go: its motion bends them far in a step.
  static constexpr int kMaxTiedRounds = 16;

  explicit AttachmentLink(std::shared_ptr<const AttachmentJoint> joint);

  const AttachmentState& state() const { return state_; }
  const AttachmentJoint& joint() const { return state_.joint(); }
  /// After the last step, for each of the joint's layers.
  std::span<const AttachmentOutcome> outcomes() const { return outcomes_; }

  /// True once all layers of a free organ are torn. It then moves in its own frame; its ducts still pull
  /// it there until they are cut, and their stumps go with it.
  bool HasLetGo(std::size_t member) const { return let_go_[member] != 0; }
  /// True if one of the ducts ends in the member.
  bool HasDucts(std::size_t member) const;
  /// The joint's ducts, to clip, cut and hold them between two steps.
  std::span<DuctState> ducts() { return state_.ducts(); }
  /// Returns the compliance of a held node of a duct with all that holds it, m/N, after a step.
  Matrix3d ComplianceOf(std::size_t duct, int node);

  /// Makes room for Keep(). Set-up only.
  void MayRepeat() { kept_.emplace(Kept{state_.solved(), w_, relief_, let_go_}); }
  /// Keeps the state before a step, only after MayRepeat(), and returns to it: the step's first solution
  /// was rejected, and Begin() follows.
  void Keep();
  void TakeBack();
  /// Begins a step. `offsets_W`: of the members, m; `bodies`: their numbers in the problem.
  void Begin(std::span<const Vector3d> offsets_W, std::span<const int> bodies);
  /// True if the members' offsets differ or a duct is not at rest: then none of them can sleep.
  bool IsMovedApart(std::span<const Vector3d> offsets_W) const;

  /// Removes a share of a sample's area, as AttachmentState does. The next step's problem is solved
  /// even if the organs sleep.
  double Burn(std::size_t layer, int sample, double share) {
    return Acted(state_.Burn(layer, sample, share));
  }
  double Cut(std::size_t layer, int sample, double share) {
    return Acted(state_.Cut(layer, sample, share));
  }
  /// True if an instrument has acted on a layer since the last step.
  bool acted() const { return acted_; }

  void Linearise(std::span<const BodyInStep> bodies, ContactSolver* solver) override;
  bool Advance(const ContactSolver& solver) override;
  void End(std::span<BodyInStep> bodies) override;
  void Follow(std::span<const BodyInStep> bodies) override;

 private:
  double Acted(double share) {
    acted_ = acted_ || share > 0;
    return share;
  }
  void FillColumns(std::span<const BodyInStep> bodies, const ContactSolver& solver);
  auto Compliance() const { return joint().compliance().leftCols(w_.size()); }
  void AddFreeDisplacements(std::span<const BodyInStep> bodies);
  void MoveByConstant();
  void LetGo(std::span<BodyInStep> bodies);
  void FindRelief(std::size_t member);
  void MoveFrames(std::span<const BodyInStep> bodies);
  int MaxRounds() const;
  void ForcesOfDucts(std::size_t member, Eigen::VectorXd* q) const;

  AttachmentState state_;
  bool acted_ = false;
  std::vector<AttachmentOutcome> outcomes_;
  std::array<int, kMaxOrgans> bodies_{};  // of each member
  int round_ = 0;                         // of the present step
  std::size_t column_count_ = 0;
  std::vector<int> equations_;    // of each side of the members' bodies
  WorkMatrix along_;              // 3r x sides: Phi H b^T along the side's axis
  WorkMatrix loaded_;             // the same along its force
  WorkMatrix half_along_, half_;  // JointSolver::Halve of the two before
  std::vector<char> let_go_;      // of each member
  bool same_ = true;              // no side has friction: its force is along its axis
  // 3r: the modes' displacements without forces, by offsets and free motion.
  Eigen::VectorXd apart_;
  Eigen::VectorXd free_;   // 3r: the same with the constant forces of layers and ducts
  Eigen::VectorXd w_, q_;  // 3r: of the last solution
  // 3r: displacements by which the torn layers' constant forces would move the ducts' modes of the
  // members let go. These forces act on the other members alone.
  Eigen::VectorXd relief_;
  Eigen::VectorXd moved_;  // 3n of the largest member with ducts, scratch
  struct Kept {
    AttachmentState::Solved state;
    Eigen::VectorXd w, relief;
    std::vector<char> let_go;
  };
  std::optional<Kept> kept_;  // before the step
};

}  // namespace hpdm
