#include "tools/replay/realtime_replay.h"

#include <chrono>
#include <cstddef>
#include <functional>
#include <latch>
#include <memory>
#include <stop_token>
#include <thread>
#include <utility>

#include "engine/threads/session_clock.h"
#include "haptics/device/device.h"
#include "tools/session/control_script.h"
#include "tools/session/realtime_threads.h"

namespace hpdm {
namespace {

// The part of a logged tick that a real-time replay needs. Small, because all ticks are in memory.
struct TraceTick {
  struct Tool {
    JointVector joints;
    Vector3d force_W;
    Nanoseconds device_late_ns;  // scheduled time of the tick minus the sample's
    bool valid, force_on;
  };
  std::uint64_t tick;
  bool has_output;
  SessionControl control;
  std::array<Tool, kMaxInstruments> tools;
};

std::vector<TraceTick> ReadTrace(const std::string& path) {
  std::vector<TraceTick> trace;
  TickReader reader(path);
  for (LoggedTick logged; reader.Next(&logged);) {
    TraceTick& tick = trace.emplace_back();
    tick.tick = logged.sample.tick;
    tick.has_output = logged.has_output;
    tick.control = ControlOf(logged.sample);
    tick.control.restart = {};  // this replay keeps no states to return to
    for (int t = 0; t < logged.sample.tool_count; ++t) {
      const ToolSample& from = logged.sample.tools[t];
      tick.tools[t] = {from.joints, from.force_W, logged.sample.time_ns - from.device_time_ns,
                       from.device_valid, from.force_on};
    }
  }
  return trace;
}

// Returns the trace's pauses and exchanges, in time since its tick 0.
ControlScript ScriptOf(const std::vector<TraceTick>& trace, Nanoseconds period) {
  std::vector<TimedControl> controls;
  SessionControl last;
  for (const TraceTick& tick : trace) {
    if (tick.control.paused == last.paused &&
        tick.control.instrument_index == last.instrument_index && tick.control.pedal == last.pedal)
      continue;
    last = tick.control;
    controls.push_back({static_cast<Nanoseconds>(tick.tick) * period, last});
  }
  return ControlScript(std::move(controls));
}

// Plays one instrument of a trace: a sample holds from its own period on. Haptic thread; wait-free.
class TraceTickDevice : public Device {
 public:
  TraceTickDevice(const std::vector<TraceTick>& trace, int tool, Nanoseconds period,
                  const DeviceLimits& limits)
      : trace_(trace), tool_(tool), period_(period), limits_(limits) {}

  // Sets the session time of tick 0. Call before the first Read.
  void Start(Nanoseconds start) { start_ = start; }

  DeviceSample Read(Nanoseconds now) noexcept override {
    while (next_ < trace_.size() && Scheduled(next_) <= now) ++next_;
    if (next_ == 0) return {};
    const TraceTick::Tool& tool = trace_[next_ - 1].tools[tool_];
    return {.sequence = next_,
            .time_ns = Scheduled(next_ - 1) - tool.device_late_ns,
            .joints = tool.joints,
            .valid = tool.valid};
  }
  void Write(const AxisEffort& /*effort*/) noexcept override {}
  void Home() override {}
  void EnableForce(bool /*on*/) noexcept override {}
  void EmergencyStop() noexcept override {}
  bool ForceOn() const noexcept override {
    return next_ > 0 && trace_[next_ - 1].tools[tool_].force_on;
  }
  DeviceLimits limits() const noexcept override { return limits_; }

 private:
  Nanoseconds Scheduled(std::size_t i) const {
    return start_ + static_cast<Nanoseconds>(trace_[i].tick) * period_;
  }

  const std::vector<TraceTick>& trace_;
  int tool_;
  Nanoseconds period_;
  DeviceLimits limits_;
  Nanoseconds start_ = 0;
  std::size_t next_ = 0;  // index after the present sample
};

// Measures the ticks as they come.
class Meter {
 public:
  // `trace`: the logged forces to compare with, or null.
  Meter(Nanoseconds period, const std::vector<TraceTick>* trace)
      : statistics_(period), trace_(trace) {}

  void Drain(SpscQueue<HapticSample>* samples) {
    for (HapticSample sample; samples->Pop(&sample);) Add(sample);
  }
  // Returns one more than the number of the last tick.
  std::uint64_t next_tick() const { return next_tick_; }
  void Report(RealtimeReplay* replay) const {
    replay->session = statistics_.Summary();
    replay->compared = compared_;
    for (int t = 0; t < kMaxInstruments; ++t) replay->forces[t] = forces_.Of(t);
  }

 private:
  void Add(const HapticSample& sample) {
    statistics_.Add(sample);
    next_tick_ = sample.tick + 1;
    if (trace_ != nullptr) Compare(sample);
  }

  void Compare(const HapticSample& sample) {
    while (next_ < trace_->size() && (*trace_)[next_].tick < sample.tick) ++next_;
    if (next_ == trace_->size()) return;
    const TraceTick& tick = (*trace_)[next_];
    if (tick.tick != sample.tick || !tick.has_output) return;
    HapticSample logged;
    logged.tool_count = sample.tool_count;
    for (int t = 0; t < sample.tool_count; ++t) logged.tools[t].force_W = tick.tools[t].force_W;
    forces_.Add(logged, sample);
    ++compared_;
  }

  SessionStatistics statistics_;
  const std::vector<TraceTick>* trace_;
  ForceDifferences forces_;
  std::uint64_t compared_ = 0;
  std::uint64_t next_tick_ = 0;
  std::size_t next_ = 0;
};

// Runs the loops as in a session (session_threads.h), without pictures and log:
//
//     device -> haptic (1 kHz) --ToolState--> deformation (30 Hz)
//                  |  ^------ContactPatch--------'
//                  |  ^------SessionControl------ this thread: the script
//                  '---HapticSample queue--> this thread: the meter
//
// Calls `started` on the haptic thread with the session time of tick 0.
RealtimeReplay Play(std::vector<HapticInstrument> instruments, std::uint64_t ticks,
                    const std::function<void(Nanoseconds)>& started, ControlScript script,
                    Meter* meter, Session* session) {
  RealtimeReplay replay;
  const SessionClock clock;
  HapticLoop haptics(
      std::move(instruments), session->haptic_period_ns(),
      {session->tool_states, session->patches, session->samples, nullptr, &session->control});
  DeformationLoop deformation(
      session->organs(), session->DeformationTools(),
      {session->tool_states, session->patches, *session->render_scenes, *session->telemetry_scenes},
      [&clock] { return clock.Now(); }, 0, session->scene().attachments, session->scene().ducts);
  RealtimeReport haptic_report, deformation_report;
  const RealtimeReport process = RequestRealtime(ProcessRealtime());
  std::latch start(2);
  std::stop_source over;
  {
    std::jthread deformation_thread([&](std::stop_token stop) {
      deformation_report = RequestRealtime(DeformationRealtime());
      start.arrive_and_wait();
      RealLoopClock loop_clock(clock);
      const int hz = session->scene().timing.deformation_hz;
      replay.deformation =
          RunOnSchedule({.start_ns = clock.Now(), .period_ns = kNanosecondsPerSecond / hz}, stop,
                        loop_clock, [&](std::uint64_t, Nanoseconds due, const TickTiming&) {
                          deformation.Step(deformation.NewestTools(), due);
                        });
    });
    std::jthread haptic_thread([&](std::stop_token stop) {
      haptic_report = RequestRealtime(HapticRealtime());
      start.arrive_and_wait();
      RealLoopClock loop_clock(clock);
      const Nanoseconds begin = clock.Now();
      started(begin);
      replay.haptic = haptics.RunRealClock(stop, loop_clock, begin, ticks);
      over.request_stop();
    });
    while (!over.stop_requested()) {
      meter->Drain(&session->samples);
      script.Advance(static_cast<Nanoseconds>(meter->next_tick()) * session->haptic_period_ns(),
                     &session->control);
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }  // joins
  meter->Drain(&session->samples);
  meter->Report(&replay);
  replay.overflows = session->samples.Overflows();
  replay.realtime = {
      {"process", process}, {"haptic", haptic_report}, {"deformation", deformation_report}};
  return replay;
}

}  // namespace

RealtimeReplay PlayInRealTime(std::uint64_t ticks, Session* session) {
  Meter meter(session->haptic_period_ns(), nullptr);
  const ForcesOn forces(session);
  return Play(
      session->HapticInstruments(), ticks, [](Nanoseconds) {}, {}, &meter, session);
}

RealtimeReplay ReplayInRealTime(const LoggedSession& log, Session* session) {
  RequireSameScene(log, *session);
  const std::vector<TraceTick> trace = ReadTrace(log.path());
  std::vector<HapticInstrument> instruments = session->HapticInstruments();
  std::vector<std::unique_ptr<TraceTickDevice>> devices;
  for (HapticInstrument& instrument : instruments) {
    devices.push_back(std::make_unique<TraceTickDevice>(trace, static_cast<int>(devices.size()),
                                                        session->haptic_period_ns(),
                                                        instrument.device->limits()));
    instrument.device = devices.back().get();
  }
  Meter meter(session->haptic_period_ns(), &trace);
  const auto start_devices = [&devices](Nanoseconds begin) {
    for (const auto& device : devices) device->Start(begin);
  };
  return Play(std::move(instruments), trace.back().tick + 1, start_devices,
              ScriptOf(trace, session->haptic_period_ns()), &meter, session);
}

}  // namespace hpdm
