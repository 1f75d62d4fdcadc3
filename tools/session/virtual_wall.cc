#include "tools/session/virtual_wall.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "engine/base/error.h"
#include "engine/mesh/collision.h"
#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

// Fills in the walls of all organs and the extremes over the vertices that the tip reaches.
class WallSurvey {
 public:
  WallSurvey(const std::vector<OrganModel>& organs, const InstrumentOptions& instrument,
             const ImpulseEngineKinematics& kinematics, const WallLimits& limits)
      : tip_radius_(instrument.geometry.tip_radius), kinematics_(kinematics), limits_(limits) {
    for (const OrganModel& organ : organs) {
      trees_.emplace_back(organ.rest().vertices, organ.rest().triangles);
    }
    wall_.limit = kInfinite;
    for (const OrganModel& organ : organs) {
      WallField& field = wall_.fields.emplace_back();
      if (!organ.rigid()) continue;
      field.resize(organ.rest().vertices.rows(), 2);
      for (int v = 0; v < field.rows(); ++v) Visit(organ, v, &field);
    }
    if (!normal_.empty()) Summarise();
  }

  VirtualWall Take() { return std::move(wall_); }

 private:
  void Visit(const OrganModel& organ, int v, WallField* field) {
    const Vector3d p_W = organ.rest().vertices.row(v), n_W = organ.rest_normals().row(v);
    const Vector3d p_tip_W = p_W + tip_radius_ * n_W;
    const bool free = IsFree(p_tip_W);
    field->row(v).setConstant(kInfinite);
    for (const double share : {0.0, 1.0}) {
      const Vector3d moved_W = share * organ.options().motion.displacement_W;
      const auto pose = kinematics_.Inverse(p_tip_W + moved_W, 0, 1);
      const Matrix3d J = kinematics_.Jacobian(pose.joints);
      const double normal = limits_.Along(J, n_W).Stiffness();
      const WallLimit least = limits_.InEveryDirection(J);
      (*field)(v, 0) = std::min((*field)(v, 0), normal);
      (*field)(v, 1) = std::min((*field)(v, 1), least.Stiffness());
      if (!free || !pose.reachable) continue;
      wall_.limit = std::min({wall_.limit, least.stability, least.friction});
      if (normal_.empty() || normal < wall_.least) {
        wall_.least = normal;
        wall_.p_least_W = p_W;
        wall_.lever = pose.joints[kInsertion];
      }
      normal_.push_back(normal);
    }
  }

  // The organs move nearly together, so their places at rest are used.
  bool IsFree(const Vector3d& p_tip_W) const {
    return std::none_of(trees_.begin(), trees_.end(), [&](const SurfaceTree& tree) {
      return tree.FirstEntry(kinematics_.p_trocar_W(), p_tip_W).at.triangle >= 0;
    });
  }

  void Summarise() {
    std::sort(normal_.begin(), normal_.end());
    wall_.reachable = true;
    wall_.median = normal_[normal_.size() / 2];
    wall_.greatest = normal_.back();
  }

  double tip_radius_;
  const ImpulseEngineKinematics& kinematics_;
  const WallLimits& limits_;
  std::vector<SurfaceTree> trees_;
  std::vector<double> normal_;  // N/m, of the vertices that the tip reaches
  VirtualWall wall_;
};

// The wall where the tip reaches no rigid organ: at the farthest insertion, along the shaft.
void UseFarthestInsertion(const ImpulseEngineKinematics& kinematics, double max_insertion,
                          const WallLimits& limits, VirtualWall* wall) {
  JointVector joints = JointVector::Zero();
  joints[kInsertion] = max_insertion;
  const Matrix3d J = kinematics.Jacobian(joints);
  const WallLimit least = limits.InEveryDirection(J);
  wall->least = wall->median = wall->greatest =
      limits.Along(J, J.col(kInsertion).normalized()).Stiffness();
  wall->limit = std::min(least.stability, least.friction);
  wall->p_least_W = kinematics.Forward(joints).translation();
  wall->lever = max_insertion;
}

}  // namespace

PassivityOptions PassivityOf(const DeviceProfile& device, double period) {
  PassivityOptions passivity;
  passivity.control = device.passivity_control;
  passivity.device = AxesOf(device);
  passivity.period = period;
  return passivity;
}

VirtualWall FindVirtualWall(const std::vector<OrganModel>& organs,
                            const InstrumentOptions& instrument,
                            const ImpulseEngineKinematics& kinematics, double period) {
  const DeviceProfile& device = instrument.device;
  const WallLimits limits(PassivityOf(device, period), device.delay, device.min_insertion,
                          device.max_insertion);
  VirtualWall wall = WallSurvey(organs, instrument, kinematics, limits).Take();
  if (!wall.reachable) UseFarthestInsertion(kinematics, device.max_insertion, limits, &wall);
  for (const OrganModel& organ : organs) {
    if (!organ.rigid() || wall.limit > 0 || organ.options().wall_stiffness) continue;
    throw InputError("instrument \"" + instrument.name +
                     "\": a device without damping or friction " +
                     "displays no rigid organ stably; give instrument.device damping and " +
                     "friction, or organ \"" + organ.options().name + "\" a wall_stiffness");
  }
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
               "instrument \"%s\" displays stably in every direction; remove it to get what each "
               "place and direction allow, or give instrument.device more friction and finer "
               "encoders",
               organ.options().name.c_str(), *given, wall.limit, instrument.c_str()));
  }
  return remarks;
}

}  // namespace hpdm
