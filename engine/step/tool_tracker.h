#pragma once

#include <array>
#include <optional>
#include <vector>

#include "engine/organ.h"
#include "engine/snapshots.h"
#include "engine/step/tool_geometry.h"

namespace hpdm {

/// Returns the tool's pose relative to the organ's breathing offset (organ_motion.h). The velocity
/// stays in the world.
ToolPose InOrganFrame(const OrganState& state, ToolPose tool);

/// One instrument's data for the deformation loop.
struct ToolOptions {
  double tip_radius = kDefaultToolRadius;    ///< m.
  double shaft_radius = kDefaultToolRadius;  ///< m.
  bool can_grasp = false;
  double prefetch = 0.05;  ///< s from a step's input to the middle of its patch's use. The use
                           ///< begins one period later and lasts one period.
  ReactionType reaction = ReactionType::kLattice;
  double k1 = 120;              ///< N/m, Eq. 29 with rest neighbours (kPaper).
  double k2 = 10;               ///< N/m.
  double wall_stiffness = 200;  ///< N/m: virtual wall of a rigid organ, for either reaction.
  std::vector<ToolGeometry> exchanges = {};  ///< Further instruments of this hand:
                                             ///< ToolPose::instrument_index 1 and up.
};

/// Follows one tool's contact with the organs from step to step: the material point under the tip,
/// the tissue in the jaws, the place where the shaft touches. Deformation thread; allocates
/// nothing.
///
/// 1. The tip's contact belongs to the haptic loop (TickContactPoint), which follows it at its own
///    rate. The step searches for it only if the tick had no patch.
/// 2. In that search a tip that pressed in the last step stays in its neighbourhood, so that a deep
///    press or a thin part is not mistaken for contact from the other side. A free tip that crossed
///    the surface since the last step starts at its point of entry, at any distance.
/// 3. A press acts on the patch of GatherKernel() around the point under the tip, with the radius
///    that the lattice resolves. The finer effect of R = max(tip radius, 1 mm) is an indentation
///    (half_space.h).
/// 4. Closing jaws take only tissue that touches them: the tip presses it, or its surface is within
///    kTouch of the jaws' capsule, as thick as the tip and two tip diameters long.
/// 5. A rigid organ is pressed as a virtual wall. The wall's isotropic compliance takes the place
///    of the indentation's, and nothing else moves. Jaws do not grasp it.
class ToolTracker {
 public:
  static constexpr double kReach = 0.06;  ///< m: no patch beyond this distance.
  /// m: tissue this near touches the jaws. The step knows the surface as the last step left it, and
  /// in 33 ms a hand at 15 mm/s moves 0.5 mm. The jaws' teeth are 0.3 mm high.
  static constexpr double kTouch = 0.0005;
  static constexpr double kGraspRadius = 0.008;      ///< m: of the grasped tissue around the touch.
  static constexpr double kJawClosed = 0.3;          ///< Closing past this grasps.
  static constexpr int kMaxGraspRows = 15;           ///< One row of 16 is left for the shaft.
  static constexpr double kMinKernelRadius = 0.001;  ///< m.

  ToolTracker(int tool, const ToolOptions& options);

  /// Finds the surface point under the tip and the tissue in the jaws. A new instrument holds
  /// nothing.
  void Track(const ToolPose& tool, const TickContactPoint& contact_point,
             const std::vector<OrganModel>& models, std::vector<OrganState>* states);

  /// The organ near the tip, -1 for none.
  int organ() const { return organ_; }
  /// The point under the tip on that organ's rest surface, m.
  Vector3d RestPoint(const std::vector<OrganModel>& models) const;

  /// Adds this tool's rows to the organs' contact constraints. False if an organ's were full.
  bool AddContacts(const ToolPose& tool, const std::vector<OrganModel>& models,
                   std::vector<OrganState>* states);

  /// Determines after the relaxation whether the tip still presses, and adds it to its organ's
  /// tips.
  void AddTip(const std::vector<OrganModel>& models, std::vector<OrganState>* states);

  /// Fills in the patch for the haptic loop, from the condensed tips.
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
  // Closest point to `p` on the neighbourhood's deformed triangles.
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
  // Returns the end of the jaws, where the shaft begins, in the tool frame, m.
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
  Neighbourhood around_;                  // around at_, at rest
  Neighbourhood prefetched_;              // around its place in the middle of a patch's use
  double gap_ = 0;                        // m, signed, from the tip's surface
  KernelPatch kernel_;                    // around at_, for a normal that the tick does not give
  Neighbourhood resolved_around_;         // at rest, as wide as the lattice resolves
  KernelSamples resolved_;                // kernel samples for the lattice row
  LocalIndentation indentation_;          // unresolved local indentation
  Vector3d normal_ = Vector3d::Zero();    // press normal; zero: not known yet
  Vector3d friction_ = Vector3d::Zero();  // press: tangential over normal force
  bool from_tick_ = false;                // the press comes from the haptic tick
  Vector3d force_W_ = Vector3d::Zero();   // on the tissue, by tip or jaws in the last step
  int tip_ = -1;                          // index among the organ's tips; -1: reaction "paper"
  Matrix3d C_loc_ = Matrix3d::Zero();     // the press row's, in the last step
  bool shaft_touches_ = false;

  int grasped_count_ = 0;
  std::array<Grasped, kMaxGraspRows> grasped_;
};

}  // namespace hpdm
