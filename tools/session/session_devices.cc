#include "tools/session/session_devices.h"

#include <algorithm>

#include "haptics/device/external_device.h"
#include "haptics/device/sim_device.h"
#include "haptics/device/simulated_hand.h"
#include "haptics/device/trace_device.h"
#include "tools/session/command_device.h"
#include "tools/session/trace_remark.h"
#include "tools/shared/report_text.h"
#include "tools/shared/with_scene_path.h"

namespace hpdm {
namespace {

constexpr double kMouseStart = 0.03;  // m, from a mouse's first position to the tissue

SessionDevice MakeTraceDevice(const InstrumentOptions& options, const HandSite& site,
                              const ImpulseEngineKinematics& kinematics, const TraceFile& file) {
  const TraceMotion motion(file.rows);
  RefuseWrongScale(file, motion, options.trace.scale);
  TraceMapping mapping{.scale = options.trace.scale,
                       .R_WF = options.trace.R_WF,
                       .position_W = options.trace.position.value_or(Vector3d::Zero()),
                       .speed = options.trace.speed};
  if (!options.trace.position) {
    mapping = Fitted(mapping, motion, site.p_target_W - options.hand.depth * site.normal_W,
                     site.normal_W);
  }
  auto device = std::make_unique<TraceDevice>(file, motion, mapping, kinematics);
  SessionDevice made;
  made.duration = device->duration();
  made.remark = "instrument \"" + options.name +
                "\": " + TraceRemark(file, motion, mapping, *device, !options.trace.position);
  made.device = std::move(device);
  return made;
}

// Returns a line for a target that the shaft does not reach, or "".
std::string ReachRemark(const InstrumentOptions& instrument, const HandSite& site,
                        const ImpulseEngineKinematics& kinematics) {
  if (kinematics.Inverse(site.p_target_W, 0, 1).reachable) return "";
  const double distance = (site.p_target_W - instrument.p_trocar_W).norm();
  return "instrument \"" + instrument.name + "\"" +
         Format(
             ": the hand's target is %.0f mm from the trocar, but the shaft reaches %.0f to "
             "%.0f mm; move the trocar or the target",
             1000 * distance, 1000 * instrument.device.min_insertion,
             1000 * instrument.device.max_insertion);
}

// Returns a place on the line to the target, at most halfway, where nothing is touched yet.
Vector3d StartOf(const HandSite& site) {
  const Vector3d out_W = site.p_trocar_W - site.p_target_W;
  return site.p_target_W + std::min(kMouseStart, 0.5 * out_W.norm()) * out_W.normalized();
}

SessionDevice MakeOnSite(const InstrumentOptions& options, const HandSite& site,
                         const ImpulseEngineKinematics& kinematics, const DeviceChoice& choice,
                         const TraceFile& trace, std::uint32_t seed) {
  SessionDevice made;
  switch (choice.type) {
    case DeviceChoice::Type::kTrace:
      return MakeTraceDevice(options, site, kinematics, trace);
    case DeviceChoice::Type::kLcm: {
      auto device = std::make_unique<ExternalDevice>(kinematics.limits());
      made.readings = &device->readings();
      made.device = std::move(device);
      return made;
    }
    case DeviceChoice::Type::kMouse: {
      auto hand = std::make_unique<MouseHand>(HandTarget{StartOf(site)}, options.hand.stiffness,
                                              options.hand.damping);
      made.hand_targets = &hand->targets();
      made.device = std::make_unique<SimDevice>(options.device, kinematics, std::move(hand));
      return made;
    }
    case DeviceChoice::Type::kCommand:
      made.device = std::make_unique<CommandDevice>(kinematics,
                                                    kinematics.Inverse(StartOf(site), 0, 1).joints);
      return made;
    case DeviceChoice::Type::kSim:
      break;
  }
  HandOptions hand = options.hand;
  if (seed != 0) hand.seed = seed;
  made.remark = ReachRemark(options, site, kinematics);
  made.device = std::make_unique<SimDevice>(options.device, kinematics,
                                            std::make_unique<SimulatedHand>(hand, site));
  return made;
}

}  // namespace

std::vector<TraceFile> ReadTraces(const std::vector<DeviceChoice>& choices) {
  std::vector<TraceFile> traces;
  for (const DeviceChoice& choice : choices) {
    traces.push_back(choice.type == DeviceChoice::Type::kTrace ? ReadTraceFile(choice.trace)
                                                               : TraceFile());
  }
  return traces;
}

SessionDevice MakeSessionDevice(const SessionModel& model, std::size_t instrument,
                                const DeviceChoice& choice, const TraceFile& trace,
                                std::uint32_t seed) {
  const InstrumentOptions& options = model.scene().instruments[instrument];
  return WithScenePath(model.scene(), [&] {
    return MakeOnSite(options, model.site(instrument), model.kinematics(instrument), choice, trace,
                      seed);
  });
}

}  // namespace hpdm
