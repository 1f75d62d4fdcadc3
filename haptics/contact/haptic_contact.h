#pragma once

#include "engine/snapshots.h"
#include "haptics/contact/lattice_reaction.h"
#include "haptics/contact/patch_surface.h"

namespace hpdm {

/// Pose and properties of a tool's tip in a tick.
struct TipPose {
  Nanoseconds time_ns = 0;                   ///< Scheduled time of the tick.
  Isometry3d X_WT = Isometry3d::Identity();  ///< Tool frame, origin at the tip's centre.
  double jaw = 1;                            ///< 0 closed .. 1 open.
  double tip_radius = 0;                     ///< m.
  double friction = 0;                       ///< Coulomb coefficient; reaction "lattice".
};

/// Contact force of one tool in one tick.
struct HapticForce {
  Vector3d reaction_W = Vector3d::Zero();  ///< Eq. 29's force on the hand, N.
  Vector3d normal_W = Vector3d::Zero();    ///< Press: the outward unit normal; else zero.
  double depth = 0;                        ///< Press: tip below the released surface, m.
  int organ = -1;
  ContactKind kind = ContactKind::kNone;
  bool rigid = false;                         ///< Press on a rigid organ's virtual wall.
  double stored = 0;                          ///< Then: energy of the wall's springs, J.
  Vector3d wall_W = Vector3d::Zero();         ///< Then: the wall's part of the reaction, N.
  Vector3d p_tip_organ_W = Vector3d::Zero();  ///< The tip relative to the organ's motion, m.
  double slip = 0;  ///< Grasp: length of the way that the tissue has slipped through the jaws, m.
};

/// Computes Eq. 29 between two deformation steps, against the newest patch of one tool on one organ.
/// It also owns the tip's contact with that organ, which begins, slides and ends here at the haptic
/// rate. The step puts its own contact at the same point (contact_point()).
///
/// Press, at a point s of the released surface:
/// 1. It begins at the foot of the tip's centre (patch_surface.h), or where the tip crossed the
///    surface since the last tick. It ends in the tick in which its force ends. Beyond the mesh's
///    triangles of the patch it begins on the coarse surface, and stays there until the next patch.
/// 2. s follows the tip so that the pressed point
///        x_c = p_original(s) + C f + C_ac f_c
///    (f, f_c: forces on the tissue by this tip and the other) stays under it.
/// 3. Each tick s walks along the surface by the tangential part of x_tip - r n - x_c, if that
///    shortens it. It walks no farther than the tip's own motion. Without this bound a contact
///    deeper than the surface's radius of curvature would run away, since there no s is in
///    equilibrium.
///
/// Reaction "lattice":
/// 1. The normal n is the released surface's interpolated normal, turned with the pressed surface:
///        n ~ n_released + tilt + R (F - the step's force),   F = f_n (friction - n),
///    with R the tilt's compliance and F the force on the tissue.
/// 2. p_original, C and C_ac are interpolated at s; lattice_reaction.h gives the force.
/// 3. Friction: if the force that holds x_c under the tip lies within the cone, s sticks and that
///    is the force. Otherwise s slips, and the tangential force lies on the cone.
///
/// Reaction "paper": depth = r - n . (x_tip - p_original), and the surface under the tip moves by
/// delta = -depth n. The force is Eq. 29's at the triangle's three corners, blended by the foot's
/// weights. A press cannot pull: a reaction component into the tissue is removed. No friction. A
/// tip of radius 0 presses when it is below the surface.
///
/// Grasp (the patch's kind is kGrasp): the held tissue moves and turns rigidly with the jaws. A jaw
/// opened beyond kJawLetsGo releases it in the same tick, whatever the patch says; the tip may then
/// press. If the force along the jaws' faces exceeds what friction holds (ToolPatch::hold), the
/// tissue slips along them until the force is on that limit (return mapping): the slip takes
/// energy and never gives any.
///
/// Hand-over: The jump that a new patch makes in the force is faded out with the time constant
/// kFade. So the arrival of a patch is not felt as a step. If the new patch has no place for the
/// contact, its force fades out in the same way. The jump of a contact that moves from the mesh's
/// triangles to the coarse surface fades too. A rigid organ's surface does not change with a patch,
/// so nothing fades there.
///
/// Haptic thread; wait-free, no allocation, never throws. The cost is bounded by the patch's caps,
/// not by the mesh.
class HapticContact {
 public:
  static constexpr double kFade = 0.02;  ///< s.

  /// `period`: haptic period, s.
  explicit HapticContact(double period = 0.001);

  /// Takes a new patch, which must stay unchanged until the next call of SetPatch or ClearPatch.
  /// That call does not read it: the writer may use its slot again by then (TripleBuffer::Front).
  void SetPatch(const ToolPatch& patch) noexcept;

  /// Removes the patch, and with it the contact.
  void ClearPatch() noexcept;

  /// Finds the contact.
  void Locate(TipPose tip) noexcept;

  /// Computes the force of one located tip, or of two. Two tips are coupled if both touch one organ;
  /// both must have been located.
  static void Solve(HapticContact* tip) noexcept;
  static void Solve(HapticContact* a, HapticContact* c) noexcept;
  const HapticForce& result() const noexcept { return result_; }
  /// The organ of the patch; -1: none.
  int organ() const noexcept { return organ_; }

  /// True if, at the last Solve, the tip touched nothing and its jaws held nothing.
  bool IsFree() const noexcept { return !touching_ && result_.kind == ContactKind::kNone; }

  /// The contact of this tick, for the deformation loop.
  TickContactPoint contact_point() const noexcept;

  /// Locates and solves for a tool alone.
  HapticForce Evaluate(const TipPose& tip) noexcept;

 private:
  void LocatePress(const TipPose& tip);
  void LocateGrasp(const TipPose& tip);
  bool FindContact(const TipPose& tip);
  bool FindFarContact(const TipPose& tip, bool moved_far);
  bool FindAgain();
  void LeavePatch(const TipPose& tip);
  const PatchSurface& surface() const { return on_far_ ? far_surface_ : surface_; }
  const auto& points() const { return on_far_ ? patch_->far.points : patch_->points; }
  template <class Value>
  Value AtFoot(Value PatchPoint::*member) const;
  bool Slide(const TipPose& tip);
  Vector3d TangentialOffset(const TipPose& tip) const;
  void EvaluateAtFoot(const TipPose& tip);
  WallStiffness WallAtFoot() const;
  Vector3d Lean() const;
  Vector3d PressedNormal() const;
  bool Sticks(const TipPose& tip);
  void PressPaper();
  void SetReaction(const Vector3d& force_on_tissue_W);
  void FadeIn();
  Vector3d AlongFaces(const Vector3d& force_W) const;
  Vector3d WayInJaws(const Vector3d& force_on_tissue_W) const;
  double ShareOfWay(const Vector3d& before_W, const Vector3d& after_W) const;
  void SlipInJaws(const Vector3d& way_T);
  void LoseContact();

  double fade_;  // factor on offset_W_ per tick
  const ToolPatch* patch_ = nullptr;
  int organ_ = -1;            // of the patch, -1 for none: SetPatch must not read the patch before
  PatchSurface surface_;      // of the mesh's triangles
  PatchSurface far_surface_;  // of the coarse ones
  HapticForce result_;
  bool started_ = false;                      // p_tip_last_W_ is known
  Vector3d p_tip_last_W_ = Vector3d::Zero();  // relative to the organ's breathing offset

  // State of the press between ticks.
  bool touching_ = false;
  bool on_far_ = false;  // foot_ is on far_surface_
  SurfaceFoot foot_;
  Vector3d p_foot_W_ = Vector3d::Zero();  // on the last patch's surface, m
  Vector3d force_W_ = Vector3d::Zero();   // on the tissue by this tip, N
  Vector3d moved_W_ = Vector3d::Zero();   // C_ac f_c: displacement by the other tip, m
  Vector3d friction_W_ = Vector3d::Zero();

  // State of the grasp between ticks.
  Vector3d slip_T_ = Vector3d::Zero();  // way of the tissue along the faces, m
  double slip_length_ = 0;              // length of that way, m
  Matrix3d R_WT_ = Matrix3d::Identity();

  // State within a tick, reaction "lattice".
  bool in_lattice_ = false;  // there is a contact to solve for
  CondensedTip tip_;
  Matrix3d coupling_W_ = Matrix3d::Zero();  // C_ac at the foot, to the other tip's step place

  // Hand-over between patches.
  bool is_new_ = false;      // the patch is new
  bool left_patch_ = false;  // the contact has just moved to the coarse surface
  bool fades_out_ = false;   // the last patch had no place for the contact
  int ticks_of_patch_ = 0;
  Vector3d raw_last_W_ = Vector3d::Zero();    // reaction without the offset in the last tick, N
  Vector3d raw_before_W_ = Vector3d::Zero();  // the same in the tick before, N
  Vector3d raw_first_W_ = Vector3d::Zero();   // and before that, N
  Vector3d offset_W_ = Vector3d::Zero();      // difference that still fades, N
};

}  // namespace hpdm
