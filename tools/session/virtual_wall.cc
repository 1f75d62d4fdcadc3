#include "tools/session/virtual_wall.h"

#include <algorithm>
#include <array>
#include <limits>

#include "engine/base/error.h"
#include "engine/mesh/collision.h"
#include "haptics/safety/stability.h"
#include "tools/shared/report_text.h"

namespace hpdm {

VirtualWall FindVirtualWall(const std::vector<OrganModel>& organs,
                            const InstrumentOptions& instrument,
                            const ImpulseEngineKinematics& kinematics, double period) {
  const DeviceProfile& device = instrument.device;
  const std::array<StiffnessLimit, 3> limits =
      StiffnessLimits(AxesOf(device), period, device.delay);
  VirtualWall wall;
  wall.limit = std::numeric_limits<double>::infinity();
  const auto visit = [&](const JointVector& joints, const Vector3d& p_W) {
    const Matrix3d J = kinematics.Jacobian(joints);
    for (int axis = 0; axis < 3; ++axis) {
      const double limit = limits[axis].stability / J.col(axis).squaredNorm();
      if (limit >= wall.limit) continue;
      wall.limit = limit;
      wall.axis = axis;
      wall.p_W = p_W;
      wall.lever = joints[kInsertion];
    }
  };
  std::vector<SurfaceTree> trees;
  for (const OrganModel& organ : organs) {
    trees.emplace_back(organ.rest().vertices, organ.rest().triangles);
  }
  // The organs move nearly together, so their places at rest are used.
  const auto is_free = [&](const Vector3d& p_tip_W) {
    return std::none_of(trees.begin(), trees.end(), [&](const SurfaceTree& tree) {
      return tree.FirstEntry(kinematics.p_trocar_W(), p_tip_W).at.triangle >= 0;
    });
  };
  for (const OrganModel& organ : organs) {
    if (!organ.rigid()) continue;
    for (Eigen::Index v = 0; v < organ.rest().vertices.rows(); ++v) {
      const Vector3d p_W = organ.rest().vertices.row(v);
      const Vector3d p_tip_W =
          p_W + instrument.geometry.tip_radius * Vector3d(organ.rest_normals().row(v));
      if (!is_free(p_tip_W)) continue;
      for (const double share : {0.0, 1.0}) {
        const Vector3d moved_W = share * organ.options().motion.displacement_W;
        const auto pose = kinematics.Inverse(p_tip_W + moved_W, 0, 1);
        if (!pose.reachable) continue;
        wall.reachable = true;
        visit(pose.joints, p_W);
      }
    }
  }
  if (!wall.reachable) {
    JointVector joints = JointVector::Zero();
    joints[kInsertion] = device.max_insertion;
    visit(joints, kinematics.Forward(joints).translation());
  }
  for (const OrganModel& organ : organs) {
    if (!organ.rigid() || wall.limit > 0 || organ.options().wall_stiffness) continue;
    throw InputError("instrument \"" + instrument.name + "\": a device without damping " +
                     "displays no rigid organ stably; give instrument.device damping, or organ \"" +
                     organ.options().name + "\" a wall_stiffness");
  }
  wall.stiffness = 0.5 * wall.limit;
  return wall;
}

std::vector<std::string> WallRemarks(const std::vector<OrganModel>& organs,
                                     const std::string& instrument, const VirtualWall& wall) {
  std::vector<std::string> remarks;
  for (const OrganModel& organ : organs) {
    const std::optional<double>& given = organ.options().wall_stiffness;
    if (!given || *given <= wall.limit) continue;
    remarks.push_back(
        Format("organ \"%s\": wall_stiffness %.0f N/m exceeds the %.0f N/m that the device of "
               "instrument \"%s\" displays stably without a damping hand; remove it to get half of "
               "that, raise timing.haptic_hz or give instrument.device more damping",
               organ.options().name.c_str(), *given, wall.limit, instrument.c_str()));
  }
  return remarks;
}

}  // namespace hpdm
