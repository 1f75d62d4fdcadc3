#pragma once

#include "engine/snapshots.h"
#include "haptics/contact/lattice_reaction.h"
#include "haptics/contact/patch_surface.h"

namespace hpdm {

/// A tool's tip as a tick has it.
struct TipPose {
  Nanoseconds time_ns = 0;                   ///< Scheduled time of the tick.
  Isometry3d X_WT = Isometry3d::Identity();  ///< Tool frame, origin at the tip's centre.
  double jaw = 1;                            ///< 0 closed .. 1 open.
  double tip_radius = 0;                     ///< m.
  double friction = 0;                       ///< Coulomb coefficient; reaction "lattice".
};

/// What one tool feels in one tick.
struct HapticForce {
  Vector3d reaction_W = Vector3d::Zero();  ///< Eq. 29's force on the hand, N.
  Vector3d normal_W = Vector3d::Zero();    ///< Press: the outward unit normal; else zero.
  double depth = 0;                        ///< Press: of the tip below the released surface, m.
  int organ = -1;
  ContactKind kind = ContactKind::kNone;
};

/// Eq. 29 between two deformation steps, against the newest patch of one tool; and the tip's
/// contact itself, which this class owns: it is made, slides and ends here, at the haptic rate, and
/// the step puts its own where the tick has it (contact_point()).
///
/// A press is at a point s of the released surface. Made: at the foot of the tip's centre
/// (patch_surface.h), or where the tip crossed the surface since the last tick. It ends in the tick
/// in which its force does. In between it goes to where the point that it presses,
///     x_c = p_original(s) + C f + C_ac f_c
/// (f, f_c: forces on the tissue of this tip and another) lies under the tip: each tick it walks
/// along the surface by the tangential part of x_tip - r n - x_c, if that becomes shorter by it,
/// and no farther than the tip's own motion explains. Deeper than the surface's radius of
/// curvature, where no s is in equilibrium, a contact would run away otherwise.
///
/// Reaction "lattice". n is the released surface's interpolated normal, turned as the pressed
/// surface turns, n ~ n_released + tilt + R (F - the step's force), with R the tilt's compliance
/// and F = f_n (friction - n) the force on the tissue along that same n. p_original, C and C_ac are
/// interpolated at s and the force is that of lattice_reaction.h. Friction: when the force that
/// would hold x_c under the tip lies within the cone, s stays and that is the force; otherwise the
/// tangential part is the cone's share of f_n in its direction, and s slips.
///
/// Reaction "paper". With depth = r - n . (x_tip - p_original), delta = -depth n is the
/// displacement of the surface under the tip and the force is Eq. 29's at the triangle's three
/// corners, blended by the foot's weights. A press cannot pull: a component of the reaction into
/// the tissue is removed. No friction. A tip of radius 0 presses when it is below the surface.
///
/// Grasp (the patch's kind is kGrasp): the held point moves rigidly with the jaws. A jaw opened
/// beyond 0.5 lets go in the same tick, whatever the patch says; the tip may then press.
///
/// Hand-over: what a new patch changes in the force beyond its own course is faded in with a time
/// constant of kFade, so that a patch's arrival is no step; the force of a contact that the new
/// patch has no place for fades out so.
///
/// Haptic thread; wait-free, no allocation, never throws. The cost is bounded by the patch's caps,
/// not by the mesh.
class HapticContact {
 public:
  static constexpr double kFade = 0.02;  ///< s.

  /// `period`: of the haptic loop, s.
  explicit HapticContact(double period = 0.001);

  /// Takes a new patch, which must stay unchanged until the next call of SetPatch or ClearPatch
  /// begins: by then the one before may be the writer's again (TripleBuffer::Front).
  void SetPatch(const ToolPatch& patch) noexcept;

  /// No patch: no contact.
  void ClearPatch() noexcept;

  /// Finds the contact.
  void Locate(TipPose tip) noexcept;

  /// The force of the contact found, of one tip alone or of the two tips of a session, which share
  /// the tissue when both touch one organ. Both must have located theirs.
  static void Solve(HapticContact* tip) noexcept;
  static void Solve(HapticContact* a, HapticContact* c) noexcept;
  const HapticForce& result() const noexcept { return result_; }

  /// The tip touches nothing and its jaws hold nothing, as far as the last Solve knows.
  bool IsFree() const noexcept { return !touching_ && result_.kind == ContactKind::kNone; }

  /// The contact of this tick, for the deformation loop.
  TickContactPoint contact_point() const noexcept;

  /// Locate and Solve, for a tool alone.
  HapticForce Evaluate(const TipPose& tip) noexcept;

 private:
  void LocatePress(const TipPose& tip);
  void LocateGrasp(const TipPose& tip);
  bool FindContact(const TipPose& tip);
  void Slide(const TipPose& tip);
  Vector3d TangentialOffset(const TipPose& tip) const;
  void EvaluateAtFoot(const TipPose& tip);
  Vector3d PressedNormal() const;
  bool Sticks(const TipPose& tip);
  void PressPaper();
  void SetReaction(const Vector3d& force_on_tissue_W);
  void FadeIn();
  void LoseContact();

  double fade_;  // of the hand-over's offset, a tick
  const ToolPatch* patch_ = nullptr;
  int organ_ = -1;  // of the patch, -1 for none: SetPatch must not read the patch before
  PatchSurface surface_;
  HapticForce result_;
  bool started_ = false;                      // p_tip_last_W_ is known
  Vector3d p_tip_last_W_ = Vector3d::Zero();  // as from the organ, which may move

  // The press, from tick to tick.
  bool touching_ = false;
  SurfaceFoot foot_;
  Vector3d p_foot_W_ = Vector3d::Zero();  // on the last patch's surface, m
  Vector3d force_W_ = Vector3d::Zero();   // on the tissue, of this tip, N
  Vector3d moved_W_ = Vector3d::Zero();   // C_ac f_c: by the other tip, m
  Vector3d friction_W_ = Vector3d::Zero();

  // Of this tick, reaction "lattice".
  bool in_lattice_ = false;  // there is a contact to solve for
  CondensedTip tip_;
  Matrix3d coupling_W_ = Matrix3d::Zero();  // C_ac at the tip's foot, of the other tip's place then

  // The hand-over between patches.
  bool is_new_ = false;     // the patch
  bool fades_out_ = false;  // the last patch had no place for the contact
  int ticks_of_patch_ = 0;
  Vector3d raw_last_W_ = Vector3d::Zero();  // the reaction without the offset, N, in the last tick
  Vector3d raw_before_W_ = Vector3d::Zero();  // and in the one before
  Vector3d offset_W_ = Vector3d::Zero();      // still to fade, N
};

}  // namespace hpdm
