#pragma once

#include <array>
#include <vector>

#include "engine/organ.h"
#include "engine/snapshots.h"

namespace hpdm {

/// What the deformation loop knows of an instrument.
struct ToolOptions {
  double tip_radius = 0.0025;    ///< m.
  double shaft_radius = 0.0025;  ///< m.
  bool can_grasp = false;
  double k1 = 120;  ///< N/m, Eq. 29 with rest neighbours.
  double k2 = 10;   ///< N/m.
};

/// Follows the contact of one tool with the organs from step to step: which material point the tip
/// presses, what the jaws hold, where the shaft touches. Deformation thread; allocates nothing.
///
/// The tip's contact follows its own neighbourhood while it lasts, so a tip that has dented the
/// tissue deeply, or a thin part, is not taken to be on the other side. A free tip that crossed the
/// surface since the last step starts where it entered, however far it has come.
class ToolContact {
 public:
  static constexpr double kReach = 0.06;         ///< m: no patch beyond this distance.
  static constexpr double kGraspReach = 0.005;   ///< m: of the tip's surface from the tissue.
  static constexpr double kGraspRadius = 0.008;  ///< m: how far the jaws reach.
  static constexpr double kJawClosed = 0.3;      ///< Closing past this grasps,
  static constexpr double kJawOpen = 0.5;        ///< opening past this lets go.
  static constexpr int kMaxGraspRows = 15;       ///< One row of 16 is left for the shaft.

  ToolContact(int tool, const ToolOptions& options) : tool_(tool), options_(options) {}

  /// Finds what the tip is at and what the jaws hold.
  void Follow(const ToolPose& tool, const std::vector<OrganModel>& models,
              std::vector<OrganState>* states);

  /// The organ that the tip is at, -1 when it is at none, and where on its rest surface (m).
  int organ() const { return organ_; }
  Vector3d RestPoint(const std::vector<OrganModel>& models) const;

  /// Adds this tool's rows to the organs' contact sets. False when a set was full.
  bool AddContacts(const ToolPose& tool, const std::vector<OrganModel>& models,
                   std::vector<OrganState>* states);

  /// After the relaxation: whether the tip still presses, and the patch for the haptic loop.
  void FillPatch(const ToolPose& tool, const std::vector<OrganModel>& models,
                 std::vector<OrganState>* states, ToolPatch* patch);

 private:
  struct Grasped {
    SurfacePoint at;
    Vector3d p_T = Vector3d::Zero();
  };

  void FollowTip(const ToolPose& tool, const std::vector<OrganModel>& models,
                 std::vector<OrganState>* states);
  bool FindEntry(const Vector3d& p_tip_W, const std::vector<OrganState>& states);
  bool FindNearest(const Vector3d& p_tip_W, const std::vector<OrganState>& states);
  void Recentre(const std::vector<OrganModel>& models, std::vector<OrganState>* states);
  void UpdateGrasp(const ToolPose& tool, const std::vector<OrganModel>& models,
                   std::vector<OrganState>* states);
  bool AddTipRows(const ToolPose& tool, const std::vector<OrganModel>& models,
                  std::vector<OrganState>* states);
  bool AddShaftRow(const ToolPose& tool, const OrganModel& model, OrganState* state);

  int tool_;
  ToolOptions options_;
  bool started_ = false;
  Vector3d p_tip_last_W_ = Vector3d::Zero();
  double jaw_last_ = 1;

  int organ_ = -1;         // nearest to the tip, or in contact
  bool touching_ = false;  // the tip carried a force in the last step
  SurfacePoint at_;        // material point under the tip
  Neighbourhood around_;   // of at_, at rest
  double gap_ = 0;         // m, signed, from the tip's surface
  bool shaft_touches_ = false;

  int grasped_count_ = 0;
  std::array<Grasped, kMaxGraspRows> grasped_;
};

}  // namespace hpdm
