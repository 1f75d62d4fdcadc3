#pragma once

#include <array>
#include <memory>

#include "engine/duct/duct_model.h"
#include "engine/duct/duct_outcome.h"

namespace hpdm {

/// Returns what is drawn of a rod.
DuctSnapshot SnapshotOf(const Rod& rod);

/// One duct in the course of a session. Its rod follows the frames of its ends. To the organs that hold
/// them it is a force on the rows w of the ends (DuctModel::Hold),
///     q = constant + stiffness w,
/// linear about the last w. Copies continue to the last bit. Deformation thread; allocates nothing after
/// its construction.
class DuctState {
 public:
  /// Largest number of unknowns: four rows of three for each end.
  static constexpr int kMaxUnknowns = 24;
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxUnknowns, 1>;
  using Matrix =
      Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxUnknowns, kMaxUnknowns>;

  explicit DuctState(std::shared_ptr<const DuctModel> model);

  const DuctModel& model() const { return *model_; }
  const Rod& rod() const { return rod_; }
  Eigen::Index unknowns() const { return unknowns_; }

  /// Gives the lattice that holds an end a moving frame: the point p at rest is at X_WF p, and w is
  /// measured in that frame.
  void SetFrame(std::size_t end, const Isometry3d& X_WF);
  /// Moves what holds an end by an offset in addition to w, m.
  void SetOffset(std::size_t end, const Vector3d& offset_W) { offsets_W_[end] = offset_W; }
  /// Takes the displacements w of the ends' rows (m) and linearises about them. True if the forces
  /// are those of the last linearisation.
  bool Follow(const Eigen::Ref<const Eigen::VectorXd>& w);
  const Vector& constant() const { return constant_; }    ///< N.
  const Matrix& stiffness() const { return stiffness_; }  ///< N/m.
  /// Takes the negative eigenvalues off the stiffness; the forces at the last w stay.
  void Stabilise();
  /// True if the duct is at rest: without organs' displacements it moves nothing.
  bool AtRest() const { return at_rest_; }

  /// Closes the lumen by a clip at an arc length at rest, m. The segment there gets stiff. False
  /// beyond the ends, beside one of them or in a gap, and where a clip is.
  bool Clip(double arc);
  /// Returns the node at which Cut(arc) cuts: the nearest one without a clip in between. -1 beside an end
  /// or a gap.
  int NodeToCut(double arc) const;
  /// Cuts the duct at NodeToCut(arc), `arc` at rest, m. Returns the node; those behind it have moved on by
  /// one. -1 beside an end, a gap or jaws, and after Rod::kMaxCuts cuts.
  int Cut(double arc);
  /// Returns the node nearest to an arc length at rest (m) that can be held, or -1.
  int NodeToHold(double arc) const;
  /// Holds a node at a place from the next step.
  void MoveHeld(int node, const Vector3d& place_W);
  void Release(int node);
  /// Returns the force that holds a node, N.
  Vector3d HoldingForce(int node) const { return rod_.HoldingForce(node); }
  /// Returns the force of a held node by its displacement (N/m), and its force on the rows w of the
  /// ends (unknowns x 3), while the rod is in equilibrium.
  struct HeldStiffness {
    Matrix3d node;
    Eigen::Matrix<double, Eigen::Dynamic, 3, 0, kMaxUnknowns, 3> rows;
  };
  HeldStiffness StiffnessOf(int node);
  int clips() const { return clips_; }
  /// Returns the clips on both sides of a place (m along the duct at rest).
  ClipsBeside ClipsBesideOf(double arc) const;

  DuctOutcome Outcome() const;
  void FillSnapshot(DuctSnapshot* snapshot) const { *snapshot = SnapshotOf(rod_); }

 private:
  int InnerNodeAt(double arc) const;
  bool FindFrames(const Eigen::Ref<const Eigen::VectorXd>& w);
  void Linearise(const Eigen::Ref<const Eigen::VectorXd>& w);

  std::shared_ptr<const DuctModel> model_;
  Rod rod_;
  Eigen::Index unknowns_ = 0;
  std::array<Vector3d, 2> offsets_W_{Vector3d::Zero(), Vector3d::Zero()};
  std::array<Isometry3d, 2> X_WF_{Isometry3d::Identity(), Isometry3d::Identity()};
  std::array<bool, 2> has_frame_{};
  std::array<Rod::Frame, 2> frames_;
  std::array<Matrix3d, 2> turns_{Matrix3d::Identity(), Matrix3d::Identity()};
  Eigen::Matrix<double, 12, Eigen::Dynamic, 0, 12, kMaxUnknowns> map_;
  Vector w_, constant_, forces_;
  Matrix stiffness_;
  Rod::EndVector gradient_ = Rod::EndVector::Zero();
  int clips_ = 0;
  std::array<double, kMaxDuctNodes> clip_arcs_{};  // m
  bool at_rest_ = true;
  bool changed_ = true;  // since the last Follow(), besides w, offsets and frames
};

}  // namespace hpdm
