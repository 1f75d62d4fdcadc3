#pragma once

#include "engine/step/grasp.h"
#include "engine/step/press_normal.h"
#include "engine/step/tip_contact.h"
#include "engine/step/tip_press.h"
#include "engine/step/tool_geometry.h"

namespace hpdm {

/// How a hand feels an organ that has no lattice force.
struct PaperReaction {
  double k1 = 120;  ///< N/m, Eq. 29 with rest neighbours.
  double k2 = 10;   ///< N/m.
};

/// Fills one tool's surface patch for the haptic loop after a step (stage D). Deformation thread;
/// allocates nothing.
class PatchBuilder {
 public:
  /// `prefetch`: see ToolOptions.
  PatchBuilder(double prefetch, const PaperReaction& reaction)
      : prefetch_(prefetch), reaction_(reaction) {}

  /// Fills in the patch of a tool without a contact: no organ.
  static void Clear(const ToolPose& tool_W, ToolPatch* patch);
  /// Fills in the rest of a cleared patch for the contact's organ, from its condensed tips. `tool`
  /// is in the organ's frame. `grasp`: what the jaws hold of this organ; nullptr: nothing.
  void Fill(const ToolPose& tool, const ToolGeometry& geometry, const TipContact& contact,
            const TipPress& press, const Grasp* grasp, const OrganModel& model, OrganState* state,
            ToolPatch* patch);

 private:
  void Prefetch(const ToolPose& tool, const TipContact& contact, const OrganModel& model,
                OrganState* state);
  bool PrefetchFar(const ToolPose& tool, const TipContact& contact, const OrganModel& model,
                   OrganState* state);
  void FillSurface(const Triangles& triangles, const TipContact& contact, const TipPress& press,
                   const OrganModel& model, OrganState* state, SurfacePatch* patch) const;
  void FillLatticeContact(const ToolGeometry& geometry, const TipContact& contact,
                          const TipPress& press, const OrganModel& model, OrganState* state,
                          ToolPatch* patch);
  void FillCouplings(const TipContact& contact, const TipPress& press, const OrganModel& model,
                     OrganState* state, ToolPatch* patch) const;
  void FillPaperContact(const TipContact& contact, const Grasp* grasp, const OrganModel& model,
                        const OrganState& state, ToolPatch* patch) const;

  double prefetch_;
  PaperReaction reaction_;
  PressNormal normal_;        // around the contact
  Neighbourhood prefetched_;  // of the mesh, around the contact's place in the middle of the
                              // patch's use; then of the coarse surface
};

}  // namespace hpdm
