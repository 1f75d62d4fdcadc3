#pragma once

#include <memory>
#include <span>
#include <vector>

#include "engine/attachment/attachment_joint.h"
#include "engine/attachment/attachment_outcome.h"

namespace hpdm {

/// The damage of the layers of one joint, and the response of its organs that follows from it.
///
/// A sample's damage has two parts. Pulling damages it by the cohesive law, to the torn share t.
/// Instruments remove a share r of its area, by burning or cutting; the rest follows the law:
///     d = t + r (1 - t).
/// Of a freed sample the share r counts as burnt or cut, and 1 - r as torn.
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
  std::span<const double> damage() const { return damage_; }
  /// Damage of each sample of one layer.
  std::span<const double> DamageOf(std::size_t layer) const;

  /// True if all of the layer is torn.
  bool IsTorn(std::size_t layer) const;
  /// Takes a torn layer away for good: it carries no pressure any more.
  void TakeAway(std::size_t layer);

  /// True for each sample that carries pressure.
  std::span<const char> closed() const { return closed_; }

  /// Takes the damage into the stiffness R, if it has changed.
  void Refactor();
  /// A few columns, stored row by row.
  using FewColumns = Eigen::Matrix<double, Eigen::Dynamic, 8, Eigen::RowMajor>;
  /// Replaces columns G^-1 w_0 (3r rows) by L^-1 G^-1 w_0 with L L^T = G^-1 + R, for
  ///     R (1 + G R)^-1 = G^-1 - G^-1 (G^-1 + R)^-1 G^-1.
  /// `scratch`: at least 3r rows.
  void HalfSettle(Eigen::Ref<Eigen::MatrixXd> columns, FewColumns* scratch) const;
  /// Replaces G^-1 w_0 by w = (1 + G R)^-1 w_0: the modes' displacements w_0 (3r, m) without the
  /// layers by those with them.
  void Settle(Eigen::Ref<Eigen::VectorXd> w) const;
  /// Returns the layers' forces q = R w, N: the organs move by -H Phi^T q.
  void ForcesOf(const Eigen::Ref<const Eigen::VectorXd>& w, Eigen::Ref<Eigen::VectorXd> q) const {
    q.noalias() = R_ * w;
  }
  /// Adds the part of the weight that the damaged layers no longer bear, N: R's change times the
  /// displacements that the weight would have given the undamaged layers.
  void AddReleasedWeight(Eigen::Ref<Eigen::VectorXd> q) const {
    if (released_.size() > 0) q += released_;
  }
  /// Takes it off G^-1 w_0.
  void TakeReleasedWeight(Eigen::Ref<Eigen::VectorXd> w) const {
    if (released_.size() > 0) w -= released_;
  }
  /// Lets the damage grow with the modes' displacements w (3r, m). True if it hardly changed, and
  /// no damaged sample opened or closed. R follows at the next Refactor().
  bool Update(const Eigen::VectorXd& w);
  /// Removes a share of a sample's area, at most what is left of it. Returns the share removed.
  double Burn(std::size_t layer, int sample, double share) {
    return Remove(layer, sample, share, &burnt_);
  }
  double Cut(std::size_t layer, int sample, double share) {
    return Remove(layer, sample, share, &cut_);
  }
  /// Returns the share of a sample's area that still holds; 0 if it has torn.
  double Left(std::size_t layer, int sample) const;
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
  Vector3d BorneBy(std::size_t sample) const {
    if (borne_.rows() == 0) return Vector3d::Zero();
    return borne_.row(static_cast<Eigen::Index>(sample));
  }

  std::shared_ptr<const AttachmentJoint> joint_;
  std::vector<double> damage_;
  std::vector<char> taken_away_;     // of each layer
  std::vector<double> torn_;         // share of the damage by the law
  std::vector<double> burnt_, cut_;  // shares of the area that instruments removed
  std::vector<double> spared_;  // of each layer, J: what tearing did not dissipate in removed area
  std::vector<char> closed_;    // of each sample: carries pressure
  Points borne_;              // of each sample, m: its displacement by the weight; empty: no weight
  Eigen::VectorXd released_;  // 3r, N, or empty
  bool changed_ = true;       // since R_ was computed
  Eigen::MatrixXd R_;         // 3r x 3r, N/m
  Eigen::MatrixXd factor_;    // 3r x 3r: lower Cholesky factor of G^-1 + R
};

}  // namespace hpdm
