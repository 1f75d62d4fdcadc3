#include "tools/haptics/tissue_hand.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "haptics/device/sim_device.h"
#include "haptics/device/simulated_hand.h"
#include "tools/shared/simple_bodies.h"
#include "tools/stress/stress_session_fixture.h"

namespace hpdm {
namespace {

constexpr double kTop = 0.05;  // m, of the ellipsoid

// A simulated device that measures the work of its motors.
class WorkMeter final : public SimDevice {
 public:
  WorkMeter(const ImpulseEngineKinematics& kinematics, std::unique_ptr<Hand> hand,
            HandCourse* course)
      : SimDevice(DeviceProfile{}, kinematics, std::move(hand)), course_(*course) {}

  DeviceSample Read(Nanoseconds now) noexcept override {
    const Vector3d before = joints().head<3>();
    const DeviceSample sample = SimDevice::Read(now);
    const Vector3d way = joints().head<3>() - before;
    work_ += effort_.dot(way);
    course_.work.push_back(work_);
    return sample;
  }
  void Write(const AxisEffort& effort) noexcept override {
    effort_ = effort;
    SimDevice::Write(effort);
  }

 private:
  HandCourse& course_;
  AxisEffort effort_ = AxisEffort::Zero();
  double work_ = 0;
};

}  // namespace

HandCourse HandleTissue(const PronySeries& prony, HandScript script, double seconds) {
  OrganOptions organ;
  organ.name = "ellipsoid";
  organ.energy.type = EnergyType::kStrain;
  organ.supports = {{BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.25)}, {}}};
  organ.material.prony = prony;

  HandCourse course;
  StressTool tool;
  tool.p_trocar_W = Vector3d(0.02, -0.1, 0.25);
  tool.tool.geometries[0].can_grasp = true;
  tool.motion = [](double) { return StressPose{.p_tip_W = Vector3d(0, 0, kTop + 0.02)}; };
  tool.device = [&](const ImpulseEngineKinematics& kinematics) {
    HandOptions options;
    options.script = script;
    const HandSite site{.p_target_W = Vector3d(0, 0, kTop),
                        .normal_W = Vector3d::UnitZ(),
                        .p_trocar_W = tool.p_trocar_W};
    return std::make_unique<WorkMeter>(kinematics, std::make_unique<SimulatedHand>(options, site),
                                       &course);
  };
  StressSessionFixture body(organ, Ellipsoid(Vector3d(0.1, 0.07, kTop), 3), {tool});
  body.RunUntil(seconds, &course.ticks);
  return course;
}

double MostGiven(const HandCourse& course) {
  return *std::max_element(course.work.begin(), course.work.end());
}

double MostGivenByLaw(const HandCourse& course) {
  double given = 0, most = 0;
  for (std::size_t i = 1; i < course.ticks.size(); ++i) {
    const ToolSample &last = course.ticks[i - 1], &tick = course.ticks[i];
    given += 0.5 * (last.reaction_W + tick.reaction_W).dot(tick.p_tip_W - last.p_tip_W);
    most = std::max(most, given);
  }
  return most;
}

double LargestForce(const HandCourse& course) {
  double largest = 0;
  for (const ToolSample& tick : course.ticks) largest = std::max(largest, tick.force_W.norm());
  return largest;
}

int Grasps(const HandCourse& course) {
  int grasps = 0;
  ContactKind last = ContactKind::kNone;
  for (const ToolSample& tick : course.ticks) {
    grasps += tick.kind == ContactKind::kGrasp && last != ContactKind::kGrasp;
    last = tick.kind;
  }
  return grasps;
}

int Reversals(const HandCourse& course) {
  int reversals = 0;
  double direction = 0;
  for (const ToolSample& tick : course.ticks) {
    if (std::abs(tick.force_W.z()) < 0.1) continue;
    const double sign = std::copysign(1, tick.force_W.z());
    reversals += sign == -direction;
    direction = sign;
  }
  return reversals;
}

}  // namespace hpdm
