#pragma once

#include "engine/snapshots.h"
#include "haptics/lattice_reaction.h"
#include "haptics/patch_surface.h"

namespace hpdm {

/// What one tool feels in one tick.
struct ContactResult {
  Vector3d reaction_W = Vector3d::Zero();  ///< Eq. 29's force on the hand, N.
  Vector3d normal_W = Vector3d::Zero();    ///< Press: the outward unit normal; else zero.
  double depth = 0;                        ///< Press: of the tip below the released surface, m.
  int organ = -1;
  ContactKind kind = ContactKind::kNone;
};

/// Eq. 29 between two deformation steps, against the newest patch of one tool.
///
/// Reaction "lattice". Press: p_original, C and n belong to the foot of the tip on the released
/// surface. A deep press would leave the released surface far behind, and with it a defined foot,
/// so the tip is first taken back by what the step's dent moved the contact: the foot of
///     x_tip + (foot of the step's contact + r n - x_tip of the step)
/// is the step's own contact when the tip has not moved since, and follows it when it has. There
/// p_original and n, interpolated, are moved by what makes them the step's own at its contact
/// (C is given so). The force is that of lattice_reaction.h. Grasp: p_current moves rigidly with
/// the jaws. Where the tip has not moved since the step, the force is the step's.
///
/// Reaction "paper". Press: with the tip's foot on the released surface (patch_surface.h), depth =
/// tip_radius - gap. When it is positive, delta = -depth n is the displacement of the surface under
/// the tip and the force is Eq. 29's at the triangle's three corners, blended by the foot's
/// weights, so that it is continuous while the tip slides from triangle to triangle. A press cannot
/// pull: a component of the reaction into the tissue is removed. A tip of radius 0 presses when it
/// is below the surface. Grasp: delta = X_WT p_grasp_T - p_original_W with the grasp's own node.
///
/// Grasp (the patch's kind is kGrasp): a jaw opened beyond 0.5 lets go in the same tick, whatever
/// the patch says; the tip may then press.
///
/// Haptic thread; wait-free, no allocation, never throws. The cost is bounded by the patch's 96
/// triangles, not by the mesh.
class TipContact {
 public:
  static constexpr double kJawLetsGo = 0.5;

  /// Takes a new patch, which must stay unchanged until the next SetPatch (TripleBuffer::Front).
  void SetPatch(const ToolPatch& patch) noexcept;

  /// No patch: no contact.
  void ClearPatch() noexcept {
    patch_ = nullptr;
    in_lattice_ = false;
  }

  /// Finds the contact. X_WT: the tool's pose; jaw 0 closed .. 1 open; tip_radius in m.
  void Locate(const Isometry3d& X_WT, double jaw, double tip_radius) noexcept;

  /// The force of the contact found, of one tip alone or of the two tips of a session, which share
  /// the tissue when both touch one organ. Both must have located theirs.
  static void Solve(TipContact* tip) noexcept;
  static void Solve(TipContact* a, TipContact* c) noexcept;
  const ContactResult& result() const noexcept { return result_; }

  /// All three, for a tool alone.
  ContactResult Evaluate(const Isometry3d& X_WT, double jaw, double tip_radius) noexcept;

 private:
  void LocatePress(const Vector3d& p_tip_W, double tip_radius);
  void LocateGrasp(const Isometry3d& X_WT);
  bool FindFoot(const Vector3d& p_tip_W, double tip_radius, SurfaceFoot* foot);
  void LocateInLattice(const Vector3d& p_tip_W, double tip_radius);
  void PressPaper(const Vector3d& p_tip_W, double tip_radius);
  void Feel(const Vector3d& force_on_tissue_W);
  void LoseContact();

  const ToolPatch* patch_ = nullptr;
  PatchSurface surface_;
  ContactResult result_;

  // Reaction "lattice".
  bool in_lattice_ = false;  // there is a contact to solve for in this tick
  LatticeTip tip_;
  Matrix3d coupling_W_ = Matrix3d::Zero();  // C_ac at the tip's foot, of the other tip's place then
  // What takes the interpolated position and normal to the step's own contact.
  Vector3d p_offset_W_ = Vector3d::Zero();
  Vector3d normal_offset_W_ = Vector3d::Zero();
  bool follows_ = false;  // the step's contact, since the last patch
  bool is_new_ = false;   // the patch: the tip may have gone far since its step
  Vector3d taken_back_W_ = Vector3d::Zero();
};

}  // namespace hpdm
