#pragma once

#include <array>
#include <vector>

#include "engine/contact/footprint.h"
#include "engine/step/tip_contact.h"
#include "engine/step/tip_press.h"
#include "engine/step/tool_geometry.h"

namespace hpdm {

/// The tissue in one tool's jaws. Deformation thread; allocates nothing.
///
/// 1. Each jaw has a face, tip_radius x 2 wide (y) and tip_radius x 4 long (z, from the tip). The
///    faces open towards +x and -x of the tool frame, each by half the opening.
/// 2. Closing jaws take the tissue between their faces: the places where the organ's surface looks
///    at the one jaw and, behind it, at the other one. They may have moved on since they closed.
/// 3. Where no tissue lies between the faces, the jaws pinch the surface that they touch (kTouch):
///    a strip about the place of the touch, as long as the opening and as wide as the faces.
/// 4. What the jaws take is a Footprint for each face, or one for the strip: it is tied to the jaws
///    and moves rigidly with them. The unresolved local compliance couples all rows of both jaws.
///    Closing jaws leave the force as it is: they hold tissue that the tip has pressed.
/// 5. If the pull exceeds what friction holds, the haptic tick lets the tissue slip along the faces
///    (TickContactPoint::slip_T), and the ties follow. When the middle of the held tissue has left
///    the faces, the jaws hold nothing.
///
/// Jaws do not grasp a rigid organ.
class Grasp {
 public:
  /// m: tissue this near touches the jaws. The step knows the surface as the last step left it, and
  /// in 33 ms a hand at 15 mm/s moves 0.5 mm. The jaws' teeth are 0.3 mm high.
  static constexpr double kTouch = 0.0005;
  /// Half the opening of the jaws, in tip radii.
  static constexpr double kHalfOpening = 2;

  explicit Grasp(int tool) : tool_(tool) {}

  /// Makes room for the rows of organs with up to `columns` control points and slots. Set-up only.
  void Reserve(Eigen::Index columns) {
    lattice_rows_.setZero(kGraspRows, columns);
    response_.setZero(3 * columns, 3);
    moved_.setZero(3 * columns);
    slots_.assign(ToSize(columns), -1);
  }

  bool holds() const { return rows_ > 0; }
  void Release() { rows_ = 0; }

  /// Takes the tissue in jaws that closed in the pose `tool` (organ's frame), and moves the contact
  /// there. `press`: of the tip in the last step, with the contact's force.
  void Take(const ToolPose& tool, const ToolGeometry& geometry, const TipPress& press,
            const OrganModel& model, OrganState* state, TipContact* contact);
  /// Moves the ties by what has slipped since the jaws closed (tool frame, m). Lets go of tissue
  /// that has left the faces.
  void Slip(const Vector3d& slip_T, const ToolGeometry& geometry);
  const Vector3d& slip_T() const { return slip_T_; }

  /// Adds the rows of the ties. `tool` is in the organ's frame. False if the organ's rows were
  /// full.
  bool AddRows(const ToolPose& tool, const OrganModel& model, OrganState* state);

  /// Returns the place of the contact in the tool frame, m.
  Vector3d ContactInTool() const { return p_contact_T_ + slip_T_; }
  /// Returns the distance (m) from the middle of the held tissue within which tissue belongs to it.
  double reach() const { return reach_; }
  /// True if the point (m, at rest) belongs to the held tissue or touches it.
  bool Holds(const Vector3d& p_rest_W) const {
    return holds() && (p_rest_W - p_middle_rest_W_).norm() < reach_;
  }

 private:
  bool TakeBetween(const ToolPose& tool, const ToolGeometry& geometry, const OrganModel& model,
                   OrganState* state, TipContact* contact);
  SurfacePoint MiddleOfNearerFace(const SurfaceMesh& rest, const SurfacePoint& pressed) const;
  bool TakeTouched(const ToolPose& tool, const ToolGeometry& geometry, const OrganModel& model,
                   OrganState* state, TipContact* contact);
  void Tie(const ToolPose& tool, const OrganModel& model, OrganState* state,
           const TipContact& contact);
  void PlaceTargets(const ToolPose& tool, const TipPress& press, const Vector3d& force_W,
                    const OrganModel& model, OrganState* state);
  double Thickness(const OrganModel& model) const;
  void UpdateLatticeRows(const OrganModel& model, const ActiveRefinement& active);

  int tool_;
  int rows_ = 0;
  bool between_ = false;                 // the tissue lies between the faces
  std::array<Footprint, 2> footprints_;  // of the jaws towards +x and -x, or of the strip alone
  LocalCoupling coupling_;
  ContactWeights lattice_rows_;  // kGraspRows x columns: the rows for the functions in `slots_`
  std::vector<int> slots_;       // function of each slot of local functions
  bool has_lattice_rows_ = false;
  Eigen::MatrixXd response_;                   // room for three loads' displacements of the lattice
  Eigen::VectorXd moved_;                      // room for one
  std::array<Vector3d, kGraspRows> p_rest_W_;  // the rows' places at rest, m
  std::array<Vector3d, kGraspRows> p_T_;       // the rows' targets as the jaws closed, m
  Vector3d p_contact_T_ = Vector3d::Zero();    // the contact as the jaws closed, m
  Vector3d middle_T_ = Vector3d::Zero();       // of the held tissue on the faces (y, z), m
  Vector3d p_middle_rest_W_ = Vector3d::Zero();
  double reach_ = 0;  // m, from the middle at rest
  Vector3d slip_T_ = Vector3d::Zero();
};

/// Returns the end of the jaws, where the shaft begins, in the tool frame, m.
inline Vector3d JawsEnd(const ToolGeometry& geometry) {
  return Vector3d(0, 0, geometry.JawsLength());
}

}  // namespace hpdm
