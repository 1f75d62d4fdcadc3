#pragma once

#include <array>
#include <optional>
#include <vector>

#include "engine/step/grasp.h"
#include "engine/step/organ_step.h"
#include "engine/step/patch_builder.h"
#include "engine/step/shaft_tracker.h"
#include "engine/step/tip_contact.h"
#include "engine/step/tip_press.h"
#include "engine/step/tool_options.h"

namespace hpdm {

/// Follows one tool's contacts with the organs from step to step. The tip has up to kMaxPlaces
/// places, on different organs or on surfaces of one organ that face different ways: the walls of a
/// notch, or two folds. Each has the material point under the tip there. The parts of a contact are
/// TipPress, Grasp and PatchBuilder, each for one place. ShaftTracker follows the shaft. Deformation
/// thread; allocates nothing.
///
/// 1. A place's contact belongs to the haptic loop (TickContactPoint), which follows it at its own
///    rate. The step searches for it only if the tick had no patch.
/// 2. In that search a tip that pressed in the last step stays in its neighbourhood. So a deep
///    press or a thin part is not mistaken for contact from the other side.
/// 3. The places that are left go to the organs whose surface a free tip crossed since the last
///    step, at any distance, and then to the nearest. The nearest organ gets a place within kReach,
///    the others only if the tip can be there before the next patch (BesideReach).
/// 4. So do further places on an organ that has one (FindBeside). A press begins there in the tick
///    only: the step prefetches. Their dents yield to each other's force like a half-space.
/// 5. A place is kept from step to step, so that the tick does not lose its contact. What the jaws
///    hold has one place only.
/// 6. Tissue that has returned onto a tool that let go (LetGo) meets nothing of it until the tool is out.
class ToolTracker {
 public:
  static constexpr double kReach = 0.06;  ///< m: no patch beyond this distance.

  ToolTracker(int tool, const ToolOptions& options);

  /// Makes room for a grasp of organs with up to `columns` control points and slots. Set-up only.
  void Reserve(Eigen::Index columns) { grasp_.Reserve(columns); }

  /// Finds the surface points under the tip and the tissue in the jaws. A new instrument holds
  /// nothing.
  void Track(const ToolPose& tool, const std::array<TickContactPoint, kToolPlaces>& contact_points,
             std::vector<OrganStep>* organs);

  /// Lets go of all tissue. Jaws that are closed hold nothing until they open.
  void LetGo();

  /// Returns the point under the tip on that organ's rest surface, m; none if the organ has no
  /// place.
  std::optional<Vector3d> RestPointOn(int organ, const OrganModel& model) const;

  /// Adds the rows of this tool's tip, or of its shaft, to the organs' contact constraints. False
  /// if an organ's were full. The tips of all tools come before the shafts.
  bool AddContacts(const ToolPose& tool, std::vector<OrganStep>* organs);
  bool AddShaftContacts(const ToolPose& tool, std::vector<OrganStep>* organs);

  /// Determines after the relaxation where the tip, or the shaft, still presses, and adds it to the
  /// organs' tips. The tips of all tools come before the shafts.
  void AddTips(std::vector<OrganStep>* organs);
  void AddShaftTips(std::vector<OrganStep>* organs);

  /// Fills in the patches for the haptic loop, from the condensed tips.
  void FillPatches(const ToolPose& tool, std::vector<OrganStep>* organs, ToolPatches* patches);

 private:
  struct Place {
    Place(int tool, int index, const ToolOptions& options);
    // Puts the contact on an organ; nothing is known of a new organ's force.
    void Take(int organ, const SurfacePoint& at, bool beside);
    TipContact contact;
    TipPress press;
    PatchBuilder patch_builder;
    bool taken = false;  // the search leaves it alone in this step
  };
  // An organ, or another wall of one, that may get a place.
  struct Candidate {
    int organ = -1;
    SurfacePoint at;
    bool beside = false;   // another place of the organ comes first
    bool entered = false;  // the tip crossed its surface since the last step
    double order = 0;      // share of the tip's way to the entry, or distance, m
  };
  struct Candidates {
    int count = 0;
    std::array<Candidate, kMaxOrgans * kMaxPlaces> list;
  };

  const ToolGeometry& geometry() const { return geometries_[instrument_index_]; }
  bool Holds(const Place& place) const {
    return grasp_.holds() && &place == &places_[holding_place_];
  }
  void TakeInstrument(const ToolPose& tool);
  void FindPierced(const ToolPose& tool, const std::vector<OrganStep>& organs);
  void KeepPlace(const ToolPose& tool, const TickContactPoint& contact_point,
                 const std::vector<OrganStep>& organs, Place* place);
  void FindCandidates(const ToolPose& tool, const std::vector<OrganStep>& organs);
  bool FindFirst(const ToolPose& tool, const OrganState& state, Candidate* candidate) const;
  void FindOthers(const ToolPose& tool, const OrganStep& organ, int index);
  void GivePlaces(const std::vector<OrganStep>& organs);
  void SearchDoublesAgain();
  bool HoldsOrgan(int organ) const {
    return grasp_.holds() && places_[holding_place_].contact.organ == organ;
  }
  bool IsTaken(int organ) const;
  void UpdateContact(const ToolPose& tool, std::vector<OrganStep>* organs, TipContact* contact);
  Place* FreePlaceNear(const Candidate& candidate, const std::vector<OrganStep>& organs);
  Place& MainPlace();
  void UpdateGrasp(const ToolPose& tool, std::vector<OrganStep>* organs);
  bool AddTipRows(const ToolPose& tool, OrganStep* organ, Place* place);
  void CoupleDents(std::vector<OrganStep>* organs);
  void AddTip(OrganStep* organ, Place* place);

  int tool_;
  ReactionType reaction_;
  std::vector<ToolGeometry> geometries_;
  std::size_t instrument_index_ = 0;
  bool started_ = false;
  // Organs that the tool was in when it let go, and still is.
  std::array<bool, kMaxOrgans> pierced_{};
  Vector3d p_tip_last_W_ = Vector3d::Zero();
  double jaw_last_ = 1;

  std::vector<Place> places_;  // kMaxPlaces
  LocalCoupling dents_;        // between places on one organ
  Candidates candidates_;
  Grasp grasp_;
  std::size_t holding_place_ = 0;  // whose organ the grasp holds
  ShaftTracker shaft_;
};

}  // namespace hpdm
