#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "lcmtypes/telemetry/exercise_events.h"
#include "lcmtypes/telemetry/telemetry_loop.h"
#include "tests/support/scratch_folder.h"
#include "tools/report/metrics/session_metrics.h"

namespace hpdm {

/// A synthetic log of ticks.
class MadeSession {
 public:
  explicit MadeSession(const std::vector<std::string>& instruments = {"probe"},
                       const TelemetryOptions& options = {},
                       const std::optional<ExerciseOptions>& exercise = {},
                       bool left_handed = false)
      : info_(Info(instruments, exercise, left_handed)),
        telemetry_(&samples_, &steps_, &scenes_, log(), options, info_),
        tools_(static_cast<int>(instruments.size())) {}

  std::string log() const { return folder_ / "session.lcmlog"; }

  /// The next tick, changed by `change`.
  void Tick(const std::function<void(HapticSample*)>& change = nullptr) {
    HapticSample sample;
    sample.tick = tick_++;
    sample.time_ns = static_cast<Nanoseconds>(sample.tick) * 1'000'000;
    sample.tool_count = tools_;
    for (ToolSample& tool : sample.tools) tool.device_valid = true;
    if (change) change(&sample);
    if (!sample.paused) device_time_ns_ = sample.time_ns;
    samples_.Push(sample);
    telemetry_.Drain();
  }
  /// A step of the last tick, with attachments.
  void Step(const std::vector<AttachmentOutcome>& attachments) {
    StepSample sample;
    sample.step.number = ++step_;
    sample.step.input_tick = tick_ - 1;
    sample.step.time_ns = static_cast<Nanoseconds>(tick_ - 1) * 1'000'000;
    sample.step.device_time_ns = device_time_ns_;
    sample.attachment_count = static_cast<int>(attachments.size());
    std::copy(attachments.begin(), attachments.end(), sample.attachments.begin());
    steps_.Push(sample);
    telemetry_.Drain();
  }
  /// A step with a press of the first instrument, N.
  void PressStep(double force, int organ) {
    StepSample sample;
    sample.step.number = ++step_;
    sample.step.time_ns = static_cast<Nanoseconds>(tick_ - 1) * 1'000'000;
    sample.step.device_time_ns = device_time_ns_;
    sample.tool_count = tools_;
    sample.contacts[0].organ = organ;
    sample.contacts[0].kind = ContactKind::kPress;
    sample.contacts[0].contact_W = Vector3d(0.01, 0.02, 0.03);
    sample.contacts[0].force_on_tissue_W = Vector3d(0, 0, -force);
    steps_.Push(sample);
    telemetry_.Drain();
  }
  /// A step with a clip on the first duct by the first instrument.
  void ClipStep() {
    StepSample sample;
    sample.step.number = ++step_;
    sample.step.time_ns = static_cast<Nanoseconds>(tick_ - 1) * 1'000'000;
    sample.step.device_time_ns = device_time_ns_;
    sample.tool_count = tools_;
    sample.duct_actions[0].kind = DuctActionKind::kClip;
    sample.duct_actions[0].duct = 0;
    sample.duct_actions[0].length = 0.03;
    sample.duct_actions[0].arc = 0.01;
    sample.duct_actions[0].coverage = 1;
    steps_.Push(sample);
    telemetry_.Drain();
  }
  /// A step with the lumens' states, whose first instrument presses an organ with its pedal pressed.
  void LumenStep(const std::vector<LumenOutcome>& lumens, int organ) {
    StepSample sample;
    sample.step.number = ++step_;
    sample.step.time_ns = static_cast<Nanoseconds>(tick_ - 1) * 1'000'000;
    sample.step.device_time_ns = device_time_ns_;
    sample.lumen_count = static_cast<int>(lumens.size());
    std::copy(lumens.begin(), lumens.end(), sample.lumens.begin());
    sample.tool_count = tools_;
    sample.tools[0].pedal = true;
    sample.tools[0].instrument_index = 1;
    sample.contacts[0].organ = organ;
    sample.contacts[0].kind = ContactKind::kPress;
    steps_.Push(sample);
    telemetry_.Drain();
  }
  /// Ticks with one instrument's force (N) on an organ; -1: without contact.
  void Press(int ticks, double force, int organ, int tool = 0) {
    for (int i = 0; i < ticks; ++i) {
      Tick([&](HapticSample* sample) {
        sample->tools[tool].force_W = {0, 0, force};
        sample->tools[tool].depth = force / 1000;
        sample->tools[tool].organ = organ;
        sample->tools[tool].kind = organ < 0 ? ContactKind::kNone : ContactKind::kPress;
      });
    }
  }
  /// Rewrites the log with events changed by `change`; false drops an event.
  SessionReading Read(const std::function<bool(LogEvent*)>& change) {
    const std::string changed = folder_ / "changed.lcmlog";
    {
      SessionLog copy(changed, 0);
      LogReader reader(log());
      for (LogEvent event; reader.Next(&event);) {
        if (change(&event)) copy.Append(event.channel.c_str(), event.time_us, event.data);
      }
    }
    return ReadSession(changed, kDefaultForceLimit, info_.held);
  }
  void Skip(int ticks) { tick_ += static_cast<std::uint64_t>(ticks); }
  SessionReading Finish(double force_limit = kDefaultForceLimit,
                        double depth_limit = kDefaultDepthLimit) {
    telemetry_.Finish();
    return ReadSession(log(), force_limit, info_.held, depth_limit, info_.exercise);
  }
  const TelemetryLoop& telemetry() const { return telemetry_; }

 private:
  static SessionInfo Info(const std::vector<std::string>& instruments,
                          const std::optional<ExerciseOptions>& exercise, bool left_handed) {
    SessionInfo info;
    info.left_handed = left_handed;
    info.exercise = exercise;
    info.instruments = instruments;
    for (const std::string& instrument : instruments) {
      info.held.push_back({instrument, "hook", "blunt"});
    }
    OrganDescription organ;
    organ.vertices = Points::Zero(3, 3);
    organ.triangles = Triangles::Zero(1, 3);
    organ.triangles << 0, 1, 2;
    for (const char* name : {"liver", "gallbladder"}) {
      organ.name = name;
      info.organs.push_back(organ);
      info.lumens.push_back(LumenName(name));
    }
    return info;
  }

  ScratchFolder folder_;
  SpscQueue<HapticSample> samples_{4096};
  SpscQueue<StepSample> steps_{16};
  TripleBuffer<SceneSnapshot> scenes_;
  SessionInfo info_;
  TelemetryLoop telemetry_;
  int tools_;
  std::uint64_t step_ = 0;
  std::uint64_t tick_ = 0;
  Nanoseconds device_time_ns_ = 0;  // of the last tick that read the devices
};

}  // namespace hpdm
