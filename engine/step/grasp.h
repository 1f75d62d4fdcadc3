#pragma once

#include <array>
#include <optional>

#include "engine/step/tip_contact.h"
#include "engine/step/tool_geometry.h"

namespace hpdm {

/// The tissue in one tool's jaws. Closing jaws take only tissue that the tip presses, or whose
/// surface is within kTouch of the jaws' capsule. The capsule is as thick as the tip and two tip
/// diameters long. Jaws do not grasp a rigid organ. Deformation thread; allocates nothing.
class Grasp {
 public:
  /// m: tissue this near touches the jaws. The step knows the surface as the last step left it, and
  /// in 33 ms a hand at 15 mm/s moves 0.5 mm. The jaws' teeth are 0.3 mm high.
  static constexpr double kTouch = 0.0005;
  static constexpr double kRadius = 0.008;   ///< m: of the grasped tissue around the touch.
  static constexpr double kJawClosed = 0.3;  ///< Closing past this grasps.
  static constexpr int kMaxRows = 15;        ///< One row of 16 is left for the shaft.

  /// Tissue that moves with the jaws.
  struct Point {
    SurfacePoint at;
    Vector3d p_T = Vector3d::Zero();  ///< In the tool frame, m.
  };

  explicit Grasp(int tool) : tool_(tool) {}

  bool holds() const { return count_ > 0; }
  const Point& first() const { return points_[0]; }
  void Release() { count_ = 0; }

  /// Takes the tissue that touches the jaws, which have just closed, and moves the contact there.
  /// `tool` is in the organ's frame.
  void Take(const ToolPose& tool, const ToolGeometry& geometry, const OrganModel& model,
            OrganState* state, TipContact* contact);
  /// Adds a row for each grasped point. `tool` is in the organ's frame. False if the organ's rows
  /// were full.
  bool AddRows(const ToolPose& tool, const OrganModel& model, OrganState* state) const;

 private:
  int tool_;
  int count_ = 0;
  std::array<Point, kMaxRows> points_;
};

/// Returns the end of the jaws, where the shaft begins, in the tool frame, m.
inline Vector3d JawsEnd(const ToolGeometry& geometry) {
  return Vector3d(0, 0, 4 * geometry.tip_radius);
}

}  // namespace hpdm
