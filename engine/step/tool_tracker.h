#pragma once

#include <array>
#include <optional>
#include <vector>

#include "engine/organ.h"
#include "engine/snapshots.h"
#include "engine/step/tool_geometry.h"

namespace hpdm {

/// The tool as an organ sees it that stands still (organ_motion.h); its velocity stays the world's.
ToolPose InOrganFrame(const OrganState& state, ToolPose tool);

/// What the deformation loop knows of an instrument.
struct ToolOptions {
  double tip_radius = kDefaultToolRadius;    ///< m.
  double shaft_radius = kDefaultToolRadius;  ///< m.
  bool can_grasp = false;
  double prefetch = 0.05;  ///< s: from a step's input to the middle of its patch's use, which
                           ///< begins one period later and lasts one.
  ReactionType reaction = ReactionType::kLattice;
  double k1 = 120;              ///< N/m, Eq. 29 with rest neighbours (kPaper).
  double k2 = 10;               ///< N/m.
  double wall_stiffness = 200;  ///< N/m, of the virtual wall that a rigid organ is to it, either
                                ///< reaction.
  std::vector<ToolGeometry> exchanges = {};  ///< What else the hand can hold:
                                             ///< ToolPose::instrument_index 1 on.
};

/// Follows the contact of one tool with the organs from step to step: which material point the tip
/// presses, what the jaws hold, where the shaft touches. Deformation thread; allocates nothing.
///
/// The tip's contact belongs to the haptic loop (TickContactPoint), which follows it at its own
/// rate. Only where that had no patch to tell from does the step find it: a tip that pressed in the
/// last step goes on in that one's neighbourhood, so a deep press or a thin part is not taken to be
/// on the other side. A free tip that crossed the surface since the last step starts where it
/// entered, however far it has come.
///
/// A press acts on the patch of GatherKernel() about the point under the tip, with the radius that
/// the lattice resolves; what R = max(tip radius, 1 mm) does more is an indentation (half_space.h).
///
/// Jaws that close take tissue that touches them, and nothing else. It touches them where the tip
/// presses it, or where its surface comes within kTouch of the jaws' capsule: as thick as the tip,
/// two tip diameters long.
///
/// A rigid organ is a press on a virtual wall: its compliance, the same in every direction, stands
/// where an indentation's would, nothing else moves, and jaws do not grasp it.
class ToolTracker {
 public:
  static constexpr double kReach = 0.06;  ///< m: no patch beyond this distance.
  /// m: tissue so near the jaws touches them. The step knows the surface as the last one left it:
  /// in 33 ms a hand at 15 mm/s moves 0.5 mm. The jaws' teeth are 0.3 mm high.
  static constexpr double kTouch = 0.0005;
  static constexpr double kGraspRadius =
      0.008;                                 ///< m: of the tissue taken, about where it touches.
  static constexpr double kJawClosed = 0.3;  ///< Closing past this grasps.
  static constexpr int kMaxGraspRows = 15;   ///< One row of 16 is left for the shaft.
  static constexpr double kMinKernelRadius = 0.001;  ///< m, of the kernel.

  ToolTracker(int tool, const ToolOptions& options);

  /// Finds what the tip is at and what the jaws hold. A new instrument in the hand holds nothing.
  void Track(const ToolPose& tool, const TickContactPoint& contact_point,
             const std::vector<OrganModel>& models, std::vector<OrganState>* states);

  /// The organ that the tip is at, -1 when it is at none, and where on its rest surface (m).
  int organ() const { return organ_; }
  Vector3d RestPoint(const std::vector<OrganModel>& models) const;

  /// Adds this tool's rows to the organs' contact constraints. False when an organ's were full.
  bool AddContacts(const ToolPose& tool, const std::vector<OrganModel>& models,
                   std::vector<OrganState>* states);

  /// After the relaxation: whether the tip still presses. Adds it to its organ's tips.
  void AddTip(const std::vector<OrganModel>& models, std::vector<OrganState>* states);

  /// The patch for the haptic loop, from the condensed tips.
  void FillPatch(const ToolPose& tool, const std::vector<OrganModel>& models,
                 std::vector<OrganState>* states, ToolPatch* patch);

 private:
  struct Grasped {
    SurfacePoint at;
    Vector3d p_T = Vector3d::Zero();
  };

  const ToolGeometry& geometry() const { return geometries_[instrument_index_]; }
  void TakeInstrument(const ToolPose& tool);
  void TrackTip(const ToolPose& tool, const TickContactPoint& contact_point,
                const std::vector<OrganModel>& models, std::vector<OrganState>* states);
  // Closest point to `p` among the neighbourhood's triangles as they are now.
  static SurfacePoint ClosestIn(const Neighbourhood& neighbourhood, const Points& vertices,
                                const Triangles& triangles, const Vector3d& p);
  bool FindEntry(const Vector3d& p_tip_W, const std::vector<OrganState>& states);
  bool FindNearest(const Vector3d& p_tip_W, const std::vector<OrganState>& states);
  void UpdateNeighbourhood(const std::vector<OrganModel>& models, std::vector<OrganState>* states);
  void UpdateGrasp(const ToolPose& tool, const std::vector<OrganModel>& models,
                   std::vector<OrganState>* states);
  // The point of the jaws' axis where tissue of organ() touches them, as the organ sees it; none if
  // it does not. Takes the contact there.
  std::optional<Vector3d> TouchOnJaws(const Isometry3d& X_WT, const std::vector<OrganModel>& models,
                                      std::vector<OrganState>* states);
  // Where the jaws end and the shaft begins, tool frame.
  Vector3d JawsEnd() const { return Vector3d(0, 0, 4 * geometry().tip_radius); }
  bool AddTipRows(const ToolPose& tool, const std::vector<OrganModel>& models,
                  std::vector<OrganState>* states);
  bool GraspsNearby(const Vector3d& p_rest_W, const ContactConstraints& contacts) const;
  bool AddShaftRow(const ToolPose& tool, const OrganModel& model, OrganState* state);
  void AddKernelToRow(const OrganModel& model, const OrganState& state,
                      Eigen::Ref<Eigen::RowVectorXd> row) const;
  Matrix3d LocalCompliance(const OrganModel& model) const;
  Vector3d KernelNormal(const OrganModel& model, const OrganState& state, const Vector3d& facing,
                        double radius);
  void FillLatticeContact(const OrganModel& model, OrganState* state, ToolPatch* patch) const;
  void FillTilt(const OrganModel& model, OrganState* state, ToolPatch* patch) const;
  SparseRow VertexRow(const OrganModel& model, int vertex, OrganState* state) const;
  void Prefetch(const ToolPose& tool, const OrganModel& model, OrganState* state);
  void FillPatchPoints(const OrganModel& model, OrganState* state, ToolPatch* patch) const;

  int tool_;
  ToolOptions options_;
  std::vector<ToolGeometry> geometries_;  // [ToolPose::instrument_index]
  std::size_t instrument_index_ = 0;
  bool started_ = false;
  Vector3d p_tip_last_W_ = Vector3d::Zero();
  double jaw_last_ = 1;

  int organ_ = -1;                        // nearest to the tip, or in contact
  bool touching_ = false;                 // the tip carried a force in the last step
  SurfacePoint at_;                       // material point under the tip
  Neighbourhood around_;                  // of at_, at rest
  Neighbourhood prefetched_;              // of where it will be in the middle of a patch's use
  double gap_ = 0;                        // m, signed, from the tip's surface
  KernelPatch kernel_;                    // about at_, for a normal that the tick does not give
  Neighbourhood resolved_around_;         // at rest, as wide as the lattice resolves
  KernelSamples resolved_;                // with which the lattice gets it
  LocalIndentation indentation_;          // the difference
  Vector3d normal_ = Vector3d::Zero();    // of the press; zero: not known yet
  Vector3d friction_ = Vector3d::Zero();  // of the press: tangential over normal force
  bool from_tick_ = false;                // the press
  Vector3d force_W_ = Vector3d::Zero();   // on the tissue, of tip or jaws in the last step
  int tip_ = -1;                          // among the organ's tips; -1: reaction "paper"
  Matrix3d C_loc_ = Matrix3d::Zero();     // of the press row in the last step
  bool shaft_touches_ = false;

  int grasped_count_ = 0;
  std::array<Grasped, kMaxGraspRows> grasped_;
};

}  // namespace hpdm
