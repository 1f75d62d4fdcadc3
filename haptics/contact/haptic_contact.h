#pragma once

#include <span>

#include "engine/contact/indentation_memory.h"
#include "engine/energy/maxwell_law.h"
#include "engine/snapshots.h"
#include "haptics/contact/lattice_reaction.h"

namespace hpdm {

/// Pose and properties of a tool's tip in a tick.
struct TipPose {
  Nanoseconds time_ns = 0;                   ///< Scheduled time of the tick.
  Isometry3d X_WT = Isometry3d::Identity();  ///< Tool frame, origin at the tip's centre.
  double jaw = 1;                            ///< 0 closed .. 1 open.
  double tip_radius = 0;                     ///< m.
  double friction = 0;                       ///< Coulomb coefficient; reaction "lattice".
  // The shaft, along z of the tool frame:
  double shaft_radius = 0;  ///< m; 0: it is not felt.
  double from_trocar = 0;   ///< Distance of the tip from the trocar, m.
  double tip_part = 0;      ///< Length from the tip that belongs to it, not to the shaft, m.
};

/// Returns the force at the tip that has the same effort on the device's axes as `force_W` on the
/// shaft: J_tip^T OnTip(F) = J_shaft^T F. `axis_W`: along the shaft, unit; `lever`: distance of the
/// place from the trocar over that of the tip.
inline Vector3d OnTip(const Vector3d& force_W, const Vector3d& axis_W, double lever) {
  return lever * force_W + (1 - lever) * axis_W.dot(force_W) * axis_W;
}

/// Contact force of one tool in one tick.
struct HapticForce {
  Vector3d reaction_W = Vector3d::Zero();  ///< Eq. 29's force on the hand, N; of a shaft: OnTip.
  Vector3d normal_W = Vector3d::Zero();    ///< Press: the outward unit normal; else zero.
  /// Press: tip below the surface that this tip has released and jaws still hold where they do, m.
  double depth = 0;
  int organ = -1;
  ContactKind kind = ContactKind::kNone;
  bool rigid = false;                  ///< Press on a rigid organ's virtual wall.
  double stored = 0;                   ///< Then: energy of the wall's springs, J.
  double tissue_stored = 0;            ///< Else: energy of the tissue's springs (TipEnergy), J.
  Vector3d wall_W = Vector3d::Zero();  ///< Then: the wall's part of the reaction, N.
  /// The tip relative to the organ's motion, m: reaction_W does the work of the contact along it.
  Vector3d p_tip_organ_W = Vector3d::Zero();
  double slip = 0;  ///< Grasp: length of the way that the tissue has slipped through the jaws, m.
};

/// Computes Eq. 29 between two deformation steps, against the newest patch of one tool on one organ.
/// It also owns the tip's contact with that organ, which begins, slides and ends here at the haptic
/// rate. The step puts its own contact at the same point (contact_point()).
///
/// Press, at a point s of the released surface:
/// 1. It begins at the foot of the tip's centre (engine/contact/patch_surface.h), or where the tip crossed the
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
///    is the force. Otherwise s slips, and the tangential force lies on the cone. It leans the normal
///    on curved tissue, with the time constant kLeans: a jump of the curvature between two triangles
///    must not hold a contact back that slips across.
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
/// Shaft: it presses like a tip, a ball of the shaft's radius whose centre lies on the axis, at a
/// distance from the trocar that follows the contact:
/// 1. The contact begins where the axis first comes as near as the radius to the released surface.
///    Between two ticks the axis advances by no more than its distance, so that no motion is too fast.
/// 2. The force is across the axis, but for friction: a smooth cylinder pushes nowhere else. The
///    normal is the pressed surface's, made perpendicular to the axis.
/// 3. The ball belongs to the shaft's material. While it slides along the axis or sticks, the
///    tissue under it is dragged as under a tip.
/// 4. The contact rolls: ball and foot move together to where the surface is parallel to the axis,
///    the deepest place of a lobe, but no farther than the shaft itself moves.
/// 5. A patch that covers one part of the shaft keeps its contact there (ShaftPart).
/// The rotation of the shaft about its axis does not rub.
///
/// Viscoelastic organ (ToolPatch::prony): p_original and C above are those that tissue with its
/// present memory shows to a force of this tick (maxwell_law.h),
///     p_original = p_inf - memory / stiffening,   C = (C_inf + (stiffening - 1) C_0) / stiffening
/// with C_0 = ToolPatch::series_W, the part of elastic supports, in series with the tissue.
/// 1. The memory under a tip follows the tick's own motion. A patch does not change it, so a held
///    contact relaxes by the law, whatever the steps do.
/// 2. It belongs to the tissue. A contact that moves from s to s' has the patch's tissue at s' plus
///    what the tick's own motion added at s; that part fades over the radius that the lattice
///    resolves. The dent under the tip has its own memory (indentation_memory.h).
/// 3. After a contact the tissue recovers in the tick too, until patches know of the release.
/// 4. A grasp begins with the step's memory of the held tissue.
///
/// Several places on one organ (StandBeside): a tip in a notch, or between two folds, presses both
/// sides.
/// 1. A contact begins beside another one only where the tip's distance from the surface is least, with
///    the tip outside and the normal turned by more than 30 degrees (PatchSurface::FindBeside). The
///    other one's force moves the surface before.
/// 2. Their forces are found together, with the couplings of the patch. So two contacts share what
///    one would carry, and none adds stiffness to it.
/// 3. Where their normals come within 20 degrees, the one with less force ends (IsOneWith). What then
///    changes fades like a hand-over.
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
  static constexpr double kFade = 0.02;   ///< s.
  static constexpr double kLeans = 0.01;  ///< s.

  enum class Part : std::uint8_t { kTip, kShaft };

  /// `period`: haptic period, s.
  explicit HapticContact(double period = 0.001, Part part = Part::kTip);

  /// Takes a new patch, which must stay unchanged until the next call of SetPatch or ClearPatch.
  /// That call does not read it: the writer may use its slot again by then (TripleBuffer::Front).
  void SetPatch(const ToolPatch& patch) noexcept;

  /// Removes the patch, and with it the contact.
  void ClearPatch() noexcept;

  /// After a copy of the contact: reads a copy of its patch instead.
  void Rebind(const ToolPatch& patch) noexcept {
    if (patch_ != nullptr) patch_ = &patch;
  }

  /// Call before Locate: of the tool's `tips`, those that press the same organ keep this one to other
  /// places, and move its tissue.
  void StandBeside(std::span<const HapticContact> tips) noexcept;
  /// Call before Locate: where other tools move the organ by their forces of the last tick, a contact
  /// begins on the moved surface.
  void StandOnMoved(std::span<const HapticContact> of_other_tool) noexcept;
  void ForgetOtherTools() noexcept { by_tools_W_.setZero(); }
  /// Finds the contact.
  void Locate(TipPose tip) noexcept;
  /// True if, at the last Locate, the contact began beside another one of its tip, which may have had
  /// its place until then.
  bool began_beside() const noexcept { return began_beside_; }
  /// True if both contacts of a tip press the same place of an organ.
  bool IsOneWith(const HapticContact& other) const noexcept;
  /// Call after Locate: ends the contact in favour of another one of the tip.
  void GiveUp() noexcept;
  /// The force changes because another contact of the tip began or ended: the change fades in.
  void FadeChange() noexcept { jumps_ = true; }

  /// Call before Locate: the shaft's contact with the same organ keeps kShaftApart from `other`,
  /// another place of the shaft.
  void KeepApartFrom(const HapticContact& other) noexcept;

  /// Computes the force of one located contact, or of two. Two are coupled if both touch one organ;
  /// both must have been located.
  static void Solve(HapticContact* tip) noexcept;
  static void Solve(HapticContact* a, HapticContact* c) noexcept;

  /// The same in parts, for more than two contacts: the forces of one or two located contacts while
  /// the others displace the tissue (PushTo), as often as needed, and then the results.
  void FindForce() noexcept;
  static void FindForces(HapticContact* a, HapticContact* c) noexcept;
  /// Once the forces are found: the depth of this press counts from where these jaws keep the tissue. A body
  /// that hangs in little but the jaws would else give way by decimetres. Of several jaws those that keep most
  /// count.
  void HoldBack(const HapticContact& jaws) noexcept;
  void Apply() noexcept;
  /// Sets the displacement of the tissue by contacts that are not in FindForces, m.
  void PushTo(const Vector3d& moved_W) noexcept;
  /// True if there is a contact with a lattice or a wall to solve for in this tick.
  bool InLattice() const noexcept { return in_lattice_; }
  /// Its force on the tissue, N, from FindForce or FindForces; before them that of the last tick.
  const Vector3d& found_W() const noexcept { return found_W_; }
  /// Returns the compliance under the last tick's force, m/N, of a contact InLattice().
  Matrix3d OwnCompliance() const noexcept { return ComplianceAt(tip_, found_W_); }
  /// Returns the compliance to another located contact on the same organ, m/N; zero if the step did
  /// not know both.
  Matrix3d CouplingTo(const HapticContact& other) const noexcept;
  /// True if the contact has a force.
  bool presses() const noexcept { return touching_ && !force_W_.isZero(0); }

  const HapticForce& result() const noexcept { return result_; }
  /// Returns how far (m) a new patch of the shaft is from its contact; 0 without a contact, and
  /// more than any shaft's length on another organ.
  double DistanceTo(const ToolPatch& patch) const noexcept;
  /// The organ of the patch; -1: none.
  int organ() const noexcept { return organ_; }

  /// True if, at the last Solve, the tip touched nothing and its jaws held nothing.
  bool IsFree() const noexcept { return !touching_ && result_.kind == ContactKind::kNone; }

  /// The contact of this tick, for the deformation loop.
  TickContactPoint contact_point() const noexcept;

  /// Locates and solves for a tool alone.
  HapticForce Evaluate(const TipPose& tip) noexcept;

 private:
  void MoveToShaft(TipPose* tip);
  void LocatePress(TipPose* tip);
  void LocateGrasp(const TipPose& tip);
  bool FindContact(const TipPose& tip);
  bool FindBeside(const TipPose& tip);
  Matrix3d ConstantCouplingTo(PlaceId place) const;
  bool FindFarContact(const Vector3d& p_last_W, const Vector3d& p_tip_W, double radius,
                      bool moved_far);
  bool FindOnShaft(TipPose* tip);
  bool FindNearest(const Vector3d& start_W, const Vector3d& end_W, SegmentFoot* near);
  bool FindInside(const TipPose& tip);
  void Roll(TipPose* tip);
  Vector3d OnAxis(double from_trocar) const { return p_trocar_W_ - from_trocar * axis_W_; }
  bool FindAgain();
  void LeavePatch(const TipPose& tip);
  const PatchSurface& mesh_surface() const { return patch_->packed; }
  const PatchSurface& far_surface() const { return patch_->far.packed; }
  const SurfacePatch& surface_patch() const { return on_far_ ? patch_->far : *patch_; }
  const PatchSurface& surface() const { return surface_patch().packed; }
  // Place of a contact on one of the patch's surfaces.
  struct Place {
    bool on_far = false;
    SurfaceFoot foot;
  };
  // Viscoelastic tissue under the tip.
  struct Memory {
    bool known = false;
    // Position without dent, and without the part in series (ToolPatch::series_W), m.
    MaxwellState<Vector3d> tissue{Vector3d::Zero(), NoBranchStrains()};
    IndentationMemory dent;
  };

  template <class Value>
  Value At(const Place& place, Value PatchPoint::*member) const {
    const auto& points = place.on_far ? patch_->far.points : patch_->points;
    const SurfaceFoot& foot = place.foot;
    return foot.weights[0] * (points[foot.corners[0]].*member) +
           foot.weights[1] * (points[foot.corners[1]].*member) +
           foot.weights[2] * (points[foot.corners[2]].*member);
  }
  template <class Value>
  Value AtFoot(Value PatchPoint::*member) const {
    return At({on_far_, foot_}, member);
  }
  bool IsViscous() const;
  Vector3d PositionOf(const Place& place) const;
  Vector3d OffsetOf(const Place& place) const;
  MaxwellState<Vector3d> TissueOfPatch(const Place& place) const;
  Memory MemoryAtFoot() const;
  void FindMemoryAgain();
  void ApplyMemory();
  Matrix3d ComplianceOfTick() const;
  void Remember(const Vector3d& force_on_tissue_W, const Vector3d& moved_W);
  void Recover();
  Vector3d HeldPoint(const Isometry3d& X_WT) const;
  bool Slide(const TipPose& tip);
  Vector3d TangentialOffset(const TipPose& tip) const;
  bool HasLeftSideways(const TipPose& tip) const;
  void EvaluateAtFoot(const TipPose& tip);
  WallStiffness WallAtFoot() const;
  Vector3d Lean() const;
  Vector3d PressedNormal() const;
  bool Sticks(const TipPose& tip);
  void PressPaper();
  void SetReaction(const Vector3d& force_on_tissue_W);
  void CountAtTip();
  void FadeIn();
  Vector3d AlongFaces(const Vector3d& force_W) const;
  Vector3d WayInJaws(const Vector3d& force_on_tissue_W) const;
  double ShareOfWay(const Vector3d& before_W, const Vector3d& after_W) const;
  void SlipInJaws(const Vector3d& way_T);
  void TakeSlipBack();
  void KeepSlip();
  void LoseContact();

  double period_;      // s
  double fade_;        // factor on offset_W_ per tick
  double lean_share_;  // of the lean's change that a tick takes
  Part part_;
  const ToolPatch* patch_ = nullptr;
  int organ_ = -1;  // of the patch, -1 for none: SetPatch must not read the patch before
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
  Vector3d lean_W_ = Vector3d::Zero();  // of the normal by friction

  // Other contacts of the tip with the organ, within a tick.
  std::array<Vector3d, kMaxPlaces> others_W_;  // their normals
  std::size_t other_count_ = 0;
  bool others_on_far_ = false;
  Vector3d by_others_W_ = Vector3d::Zero();  // displacement at the patch's place, m
  Vector3d by_tools_W_ = Vector3d::Zero();   // the same by other tools
  bool began_beside_ = false;

  // State of a shaft between ticks.
  double from_trocar_ = 0;                     // of the pressing part, m
  double tip_from_trocar_ = 0;                 // m
  Vector3d p_tool_last_W_ = Vector3d::Zero();  // the tool's tip
  bool is_patch_new_ = true;                   // the axis has not been searched on it
  bool axis_known_ = false;                    // of the last tick, between these ends, m
  std::array<Vector3d, 2> axis_last_W_;
  double clearance_ = 0;  // m: the shaft was this far from the surface then, or farther

  // State of a shaft within a tick.
  Vector3d axis_W_ = Vector3d::UnitZ();  // from the tip to the trocar
  Vector3d p_trocar_W_ = Vector3d::Zero();
  double end_ = 0;                              // m from the trocar: the tip's part begins
  ShaftPart apart_;                             // of the shaft, from another contact
  double longest_roll_ = 0;                     // m
  double end_on_ = 0;                           // cosine between axis and pressed normal
  bool at_border_ = false;                      // begins where the surface's normals lie along it
  Vector3d organ_offset_W_ = Vector3d::Zero();  // by the organ's motion

  // State of the grasp between ticks.
  Vector3d slip_T_ = Vector3d::Zero();  // way of the tissue along the faces, m
  double slip_length_ = 0;              // length of that way, m
  Vector3d way_T_ = Vector3d::Zero();   // of this tick, not yet in slip_T_, m
  Matrix3d R_WT_ = Matrix3d::Identity();

  // State within a tick, reaction "lattice".
  bool in_lattice_ = false;  // there is a contact to solve for
  CondensedTip tip_;
  Matrix3d coupling_W_ = Matrix3d::Zero();  // C_ac at the foot, to the other tip's step place
  Vector3d pushed_W_ = Vector3d::Zero();    // displacement by PushTo, in tip_
  Vector3d held_W_ = Vector3d::Zero();      // displacement by what jaws answer the tip, m
  Vector3d found_W_ = Vector3d::Zero();     // force on the tissue, N

  // Viscoelastic organ.
  MaxwellStep step_;                             // since the last tick
  Nanoseconds time_ns_ = 0;                      // of the last tick
  Memory memory_;                                // after the last tick
  bool memory_of_grasp_ = false;                 // memory_.tissue is that of the held point
  Vector3d force_on_held_W_ = Vector3d::Zero();  // in the last tick, N
  double unpressed_ = 0;                         // s, since memory_ carried a force
  Place memory_place_;                           // press: where memory_ is
  Vector3d p_memory_W_ = Vector3d::Zero();       // the same, m
  MaxwellState<Vector3d> patch_tissue_;          // the patch's tissue there
  Memory present_;                               // at the foot of this tick, before its force
  Vector3d p_free_W_ = Vector3d::Zero();  // tissue there without this tick's force or dent, m
  Isometry3d X_WT_last_ = Isometry3d::Identity();  // relative to the organ's breathing offset

  // Hand-over between patches.
  bool is_new_ = false;     // the patch is new
  bool jumps_ = false;      // the force jumps, but not by a new patch
  bool fades_out_ = false;  // the last patch had no place for the contact
  int ticks_of_patch_ = 0;
  Vector3d raw_last_W_ = Vector3d::Zero();    // reaction without the offset in the last tick, N
  Vector3d raw_before_W_ = Vector3d::Zero();  // the same in the tick before, N
  Vector3d raw_first_W_ = Vector3d::Zero();   // and before that, N
  Vector3d offset_W_ = Vector3d::Zero();      // difference that still fades, N
};

}  // namespace hpdm
