#pragma once

#include <vector>

#include "engine/step/grasp.h"
#include "engine/step/organ_step.h"
#include "engine/step/patch_builder.h"
#include "engine/step/tip_contact.h"
#include "engine/step/tip_press.h"
#include "engine/step/tool_geometry.h"

namespace hpdm {

/// One instrument's data for the deformation loop.
struct ToolOptions {
  std::vector<ToolGeometry> geometries = {ToolGeometry()};  ///< [ToolPose::instrument_index]
  double prefetch = 0.05;  ///< s from a step's input to the middle of its patch's use. The use
                           ///< begins one period later and lasts one period.
  ReactionType reaction = ReactionType::kLattice;
  double k1 = 120;              ///< N/m, Eq. 29 with rest neighbours (kPaper).
  double k2 = 10;               ///< N/m.
  double wall_stiffness = 200;  ///< N/m: virtual wall of a rigid organ, for either reaction.
};

/// Follows one tool's contact with the organs from step to step: the organ and the material point
/// under the tip. The parts of the contact are TipPress, Grasp, AddShaftContact and PatchBuilder,
/// each for one organ. Deformation thread; allocates nothing.
///
/// 1. The tip's contact belongs to the haptic loop (TickContactPoint), which follows it at its own
///    rate. The step searches for it only if the tick had no patch.
/// 2. In that search a tip that pressed in the last step stays in its neighbourhood. So a deep
///    press or a thin part is not mistaken for contact from the other side. A free tip that crossed
///    the surface since the last step starts at its point of entry, at any distance.
class ToolTracker {
 public:
  static constexpr double kReach = 0.06;  ///< m: no patch beyond this distance.

  ToolTracker(int tool, const ToolOptions& options);

  /// Finds the surface point under the tip and the tissue in the jaws. A new instrument holds
  /// nothing.
  void Track(const ToolPose& tool, const TickContactPoint& contact_point,
             std::vector<OrganStep>* organs);

  /// The organ near the tip, -1 for none.
  int organ() const { return contact_.organ; }
  /// The point under the tip on that organ's rest surface, m.
  Vector3d RestPoint(const std::vector<OrganStep>& organs) const;

  /// Adds this tool's rows to the organs' contact constraints. False if an organ's were full.
  bool AddContacts(const ToolPose& tool, std::vector<OrganStep>* organs);

  /// Determines after the relaxation whether the tip still presses, and adds it to its organ's
  /// tips.
  void AddTip(std::vector<OrganStep>* organs);

  /// Fills in the patch for the haptic loop, from the condensed tips.
  void FillPatch(const ToolPose& tool, std::vector<OrganStep>* organs, ToolPatch* patch);

 private:
  const ToolGeometry& geometry() const { return geometries_[instrument_index_]; }
  void TakeInstrument(const ToolPose& tool);
  void TrackTip(const ToolPose& tool, const TickContactPoint& contact_point,
                std::vector<OrganStep>* organs);
  bool FindEntry(const Vector3d& p_tip_W, const std::vector<OrganStep>& organs);
  bool FindNearest(const Vector3d& p_tip_W, const std::vector<OrganStep>& organs);
  void UpdateGrasp(const ToolPose& tool, std::vector<OrganStep>* organs);
  bool AddTipRows(const ToolPose& tool, OrganStep* organ);

  int tool_;
  ReactionType reaction_;
  std::vector<ToolGeometry> geometries_;
  std::size_t instrument_index_ = 0;
  bool started_ = false;
  Vector3d p_tip_last_W_ = Vector3d::Zero();
  double jaw_last_ = 1;

  TipContact contact_;
  TipPress press_;
  Grasp grasp_;
  bool shaft_touches_ = false;
  PatchBuilder patch_builder_;
};

}  // namespace hpdm
