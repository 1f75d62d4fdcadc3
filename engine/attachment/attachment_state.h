#pragma once

#include <memory>
#include <span>
#include <vector>

#include "engine/attachment/attachment_joint.h"
#include "engine/attachment/attachment_outcome.h"
#include "engine/attachment/joint_solver.h"
#include "engine/duct/duct_state.h"

namespace hpdm {

/// The damage of the layers of one joint and the shapes of its ducts, and the response of its organs
/// that follows from them.
///
/// A sample's damage has two parts. Pulling damages it by the cohesive law, to the torn share t.
/// Instruments remove a share r of its area, by burning or cutting; the rest follows the law:
///     d = t + r (1 - t).
/// A freed sample counts as burnt or cut with the share r, and as torn with 1 - r.
///
/// Under gravity the shape at rest is that under the organs' weight W. Supports and layers bear it as
/// they would if it came upon them unstressed: a layer's samples then have the displacements
/// delta_g = M (1 + G R)^-1 Phi H W, and the tractions k delta_g at the start. So their law is that of
/// delta + delta_g, and what damage takes from it, R_0 delta_g - R delta_g, moves the organs.
/// Copies continue to the last bit. Deformation thread; allocates nothing after its construction.
class AttachmentState {
 public:
  explicit AttachmentState(std::shared_ptr<const AttachmentJoint> joint);

  const AttachmentJoint& joint() const { return *joint_; }
  /// Damage of each sample of the layers in turn.
  std::span<const double> damage() const { return now_.damage; }
  /// Damage of each sample of one layer.
  std::span<const double> DamageOf(std::size_t layer) const;
  /// Burnt share of each sample of one layer.
  std::span<const double> BurntOf(std::size_t layer) const;

  /// True if nothing of the layer is left: it is torn, burnt or cut.
  bool IsTorn(std::size_t layer) const;
  /// Takes a torn layer away for good: it carries no pressure any more.
  void TakeAway(std::size_t layer);

  /// True for each sample that carries pressure.
  std::span<const char> closed() const { return now_.closed; }

  /// The joint's ducts, in its order.
  std::span<DuctState> ducts() { return now_.ducts; }
  std::span<const DuctState> ducts() const { return now_.ducts; }

  /// Takes the damage and the ducts' tangents into the stiffness R, if they have changed. Needed before
  /// solver() is used.
  void Refactor();
  /// The same, but where no sample's damage has changed much since the last time, its change acts as
  /// constant forces at the displacements w, and R takes the ducts alone. The next Refactor() takes the rest.
  void RefactorOrDefer(const Eigen::VectorXd& w);
  /// The response with the present stiffness R.
  const JointSolver& solver() const { return solver_; }
  /// 3r, N: the forces at w = 0, besides R w. The part of the weight that the damaged layers no longer
  /// bear, which is R's change times the displacements that the weight would have given the undamaged
  /// layers; and those of the ducts. The organs move by -H Phi^T (R w + constant).
  const Eigen::VectorXd& constant() const { return constant_; }
  /// Lets the damage grow with the modes' displacements w (3r, m), and moves the ducts. True if the
  /// damage and the ducts' forces hardly changed, and no damaged sample opened or closed. R follows
  /// at the next Refactor().
  bool Update(const Eigen::VectorXd& w);
  /// Moves the ducts with the modes' displacements. True if their forces hardly changed.
  bool MoveDucts(const Eigen::VectorXd& w);
  /// Removes a share of a sample's area, at most what is left of it. Returns the share removed.
  double Burn(std::size_t layer, int sample, double share) {
    return Remove(layer, sample, share, &burnt_);
  }
  double Cut(std::size_t layer, int sample, double share) {
    return Remove(layer, sample, share, &cut_);
  }
  /// Returns the share of a sample's area that still holds; 0 if it has torn.
  double Left(std::size_t layer, int sample) const;
  /// The part of the state that a step's solution changes.
  struct Solved {
    std::vector<double> damage, torn;  // of each sample; torn: share of the damage by the law
    std::vector<double> spared;  // of each layer, J: what tearing did not dissipate in removed area
    std::vector<char> taken_away;  // of each layer
    std::vector<char> closed;      // of each sample: carries pressure
    std::vector<DuctState> ducts;
  };
  /// To keep it allocates at the first time only.
  const Solved& solved() const { return now_; }
  /// Returns to a kept one.
  void TakeBack(const Solved& kept);
  /// The layers' state; their loads at the modes' displacements w with the present R.
  void Report(const Eigen::VectorXd& w, std::span<AttachmentOutcome> outcomes) const;

 private:
  Vector3d DisplacementOf(const AttachmentJoint::Layer& layer, int sample,
                          const Eigen::VectorXd& w) const;

  double Remove(std::size_t layer, int sample, double share, std::vector<double>* by);
  std::size_t Number(std::size_t layer, int sample) const;
  double DamageWith(double torn, double removed) const {
    return removed >= 1 ? 1 : torn + removed * (1 - torn);
  }
  void BearWeight();
  void AddLayers();
  void AddConstants();
  void AddDucts();
  void AddDeferred(const Eigen::VectorXd& w);
  /// Adds a force on one of a layer's samples, N.
  void AddConstant(const AttachmentJoint::Layer& layer, int sample, const Vector3d& force_W);
  void FillStiffness(std::size_t layer, std::size_t first_sample);
  Vector3d BorneBy(std::size_t sample) const {
    if (borne_.rows() == 0) return Vector3d::Zero();
    return borne_.row(static_cast<Eigen::Index>(sample));
  }

  std::shared_ptr<const AttachmentJoint> joint_;
  Solved now_;
  std::vector<double> burnt_, cut_;  // shares of the area that instruments removed
  Points borne_;  // of each sample, m: its displacement by the weight; empty: no weight
  JointSolver solver_;
  Eigen::VectorXd constant_;
  std::vector<char> changed_;            // of each layer: its part of R is to be computed
  std::vector<double> factored_damage_;  // of each sample: the damage that R has
  std::vector<char> factored_closed_;    // of each sample: R has it closed
  bool ducts_changed_ = true;
};

}  // namespace hpdm
