#pragma once

#include <array>
#include <span>
#include <vector>

#include "engine/step/grasp.h"
#include "engine/step/organ_step.h"
#include "engine/step/patch_builder.h"
#include "engine/step/tip_contact.h"
#include "engine/step/tip_press.h"
#include "engine/step/tool_options.h"

namespace hpdm {

/// Follows the contacts of one tool's shaft with the organs from step to step. The shaft has up to
/// kShaftPlaces places, on different organs or kShaftApart from each other on one. At each it presses
/// like a tip: a ball of the shaft's radius whose centre lies on the shaft's axis. The normal is
/// across the axis, since a smooth cylinder pushes nowhere else. Deformation thread; allocates
/// nothing.
///
/// 1. A contact belongs to the haptic loop, as a tip's does (ToolTracker).
/// 2. Other places go to the organs that the shaft entered since the last step. The search is
///    continuous: no organ is passed through, at any speed (SurfaceTree::FirstTouch).
/// 3. Then to those that it reaches within kAhead at its present velocity, where it will touch them,
///    and to the nearest.
/// 4. The jaws' part of the shaft, and what lies below the surface behind a pressing tip, belong to
///    the tip. So does tissue beside the tool's own grasp, which moves with the jaws: a shaft that
///    pushed it away would lever it out of them.
/// 5. A shaft that enters the surface end on, with more than kMaxEndOn between axis and normal, only
///    follows its own tip's indentation. One that touches from outside between its ends is never
///    end on, whatever the normals of the border that it touches.
class ShaftTracker {
 public:
  static constexpr double kAhead = 0.1;  ///< s: a patch is used up to this long after its step.

  ShaftTracker(int tool, const ToolOptions& options);

  /// The instrument in a step.
  struct Input {
    const ToolPose& tool;
    const ToolGeometry& geometry;
    double below = 0;     ///< m of the shaft below the surface, behind the tip.
    int held_organ = -1;  ///< The organ that `grasp` holds.
    const Grasp* grasp = nullptr;
    std::array<bool, kMaxOrgans> pierced{};  ///< Organs that meet nothing of the tool.
  };

  /// Forgets the contacts of another instrument.
  void Release();
  /// Finds the parts of the shaft that press and the surface points there.
  void Track(const Input& input, std::span<const TickContactPoint, kShaftPlaces> contact_points,
             std::vector<OrganStep>* organs);
  /// Adds the shaft's rows to the organs' contact constraints. False if an organ's were full.
  bool AddContacts(const ToolPose& tool, const ToolGeometry& geometry,
                   std::vector<OrganStep>* organs);
  /// Adds the places that press to the organs' tips, after the relaxation.
  void AddTips(std::vector<OrganStep>* organs);
  /// Fills in the patches for the haptic loop, from the condensed tips.
  void FillPatches(const ToolPose& tool, const ToolGeometry& geometry,
                   std::vector<OrganStep>* organs, std::span<ToolPatch, kShaftPlaces> patches);

  /// True if the shaft touched an organ in the last step.
  bool touches() const;

 private:
  struct Place {
    Place(int tool, const ToolOptions& options);
    TipContact contact;
    TipPress press;
    PatchBuilder patch_builder;
    double from_trocar = 0;  // m
    bool ahead = false;      // the shaft will be there
    bool taken = false;      // the search leaves it alone in this step
  };
  // The shaft's axis in a step.
  struct Axis {
    Vector3d p_trocar_W = Vector3d::Zero();
    Vector3d direction_W = Vector3d::UnitZ();  // from the tip to the trocar
    double length = 0;                         // m, from the trocar to the tip
    double end = 0;                            // m, from the trocar to where the tip's part begins
    Vector3d At(double from_trocar) const { return p_trocar_W - from_trocar * direction_W; }
  };
  // A part of the axis, m from the trocar.
  struct Part {
    double from = 0, to = 0;
  };
  // A place that the shaft touches or may touch.
  struct Candidate {
    int organ = -1;
    SurfacePoint at = {};
    double from_trocar = 0;
    bool entered = false;  // since the last step
    bool ahead = false;
    double order = 0;      // part of the way to the entry, or distance, m
    bool outside = false;  // touched from outside, between the axis' ends
  };
  struct Candidates {
    int count = 0;
    std::array<Candidate, kMaxOrgans * kShaftPlaces> list;
  };

  static Axis AxisOf(const ToolPose& tool, double end);
  double EndOn(int organ, const Input& input) const;
  void KeepPlace(const Input& input, const TickContactPoint& contact_point,
                 const std::vector<OrganStep>& organs, Place* place) const;
  void FindCandidates(const Input& input, const std::vector<OrganStep>& organs);
  bool FindIn(const Part& part, const Input& input, const OrganStep& organ,
              Candidate* candidate) const;
  bool Counts(const Input& input, const OrganStep& organ, const Candidate& candidate) const;
  void GivePlaces();
  void UpdateContact(const Input& input, std::vector<OrganStep>* organs, Place* place) const;
  ShaftPart PartOf(const Place& place) const;
  ToolPose BallAt(const ToolPose& tool, const Place& place) const;

  int tool_;
  ReactionType reaction_;
  bool started_ = false;
  Axis axis_, axis_last_;
  std::array<double, kMaxOrgans> ends_{};  // m, Axis::end on each organ
  std::vector<Place> places_;              // kShaftPlaces
  Candidates candidates_;
};

}  // namespace hpdm
