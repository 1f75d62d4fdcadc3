#include "tools/haptics/shaft_trials.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hpdm {
namespace {

constexpr double kTick = 1e-3;  // s

double DistanceFromOrigin(const ToolPose& tool) {
  const Vector3d axis = tool.X_WT.linear().col(2);
  return axis.cross(tool.p_trocar_W).norm();
}

}  // namespace

ToolPose ShaftAcross(double z, double speed) {
  ToolPose tool;
  tool.p_trocar_W = kShaftTrocar;
  const auto direction = [](double height) {
    return Vector3d(kShaftToLobe, 0, height - kShaftTrocar.z()).normalized();
  };
  const Vector3d out = -direction(z);
  tool.X_WT.linear().col(1) = Vector3d::UnitY();
  tool.X_WT.linear().col(2) = out;
  tool.X_WT.linear().col(0) = Vector3d::UnitY().cross(out);
  tool.X_WT.translation() = kShaftTrocar - kShaftInserted * out;
  tool.v_tip_W = kShaftInserted * (direction(z - speed * kTick) - direction(z)) / kTick;
  return tool;
}

OrganOptions RigidLobe() {
  OrganOptions options;
  options.name = "lobe";
  options.model = OrganModelType::kRigid;
  options.wall_stiffness = kLobeWall;
  return options;
}

OrganOptions SoftLobe() {
  OrganOptions options;
  options.name = "lobe";
  options.energy.type = EnergyType::kStrain;
  options.lattice.cells = {4, 4, 6};
  options.lattice.margin = 0.004;
  options.lattice.local.functions = 0;
  options.supports.push_back({BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.4)}, {}});
  return options;
}

ShaftSweep SweepShaftDown(FeltBench* bench, double lobe_top, double depth, double speed) {
  ShaftSweep sweep{.least_held = std::numeric_limits<double>::infinity()};
  const double touch = lobe_top + kDefaultToolRadius, start = touch + 0.01 + 0.1 * speed;
  for (int i = 0; i < 40; ++i) bench->SessionTick(ShaftAcross(start));
  Vector3d last = Vector3d::Zero();
  bool felt = false;
  const auto judge = [&](const ToolPose& tool) {
    bench->SessionTick(tool);
    const Vector3d hand = bench->Hand();
    sweep.largest_step = std::max(sweep.largest_step, (hand - last).norm());
    last = hand;
    const double meant = std::max(0.0, touch - DistanceFromOrigin(tool)) * kLobeWall;
    const double lever = bench->Felt().organ < 0 ? 1 : kShaftInserted / kShaftToLobe;  // nearly
    sweep.worst = std::max(sweep.worst, std::abs(lever * hand.norm() - meant));
    felt = felt || !hand.isZero(0);
    if (felt) sweep.least_held = std::min(sweep.least_held, hand.norm());
    sweep.late += meant > 0 && hand.isZero(0);
  };
  double z = start;
  for (; z > touch - depth; z -= kTick * speed) judge(ShaftAcross(z, speed));
  for (int i = 0; i < 200; ++i) judge(ShaftAcross(touch - depth));
  sweep.last = last.norm();
  if (!felt) sweep.least_held = 0;
  return sweep;
}

}  // namespace hpdm
