#pragma once

#include <deque>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "haptics/haptic_loop.h"
#include "lcmtypes/telemetry/telemetry_loop.h"
#include "scenes/loader/scene.h"
#include "tools/session/control_script.h"
#include "tools/session/session.h"

namespace hpdm {

/// How a session of the tests is recorded.
struct Recording {
  std::string scene;     ///< Path.
  std::string log;       ///< Path.
  int ticks = 400;       ///< Periods, skipped ones included.
  int hand_lead_ms = 0;  ///< The hands start so far into their scripts, before the first tick.
  /// 0: the lockstep clock. Else what threads on a busy machine do, seeded: ticks late or skipped,
  /// steps of 5 to 80 ms, patches replaced before a tick sees them, devices that answer nothing for
  /// a while, relaxations that their clock stops.
  std::uint32_t busy_seed = 0;
  std::vector<TimedControl> wishes = {};           ///< What is asked of the session and when.
  std::function<void(int)> before_tick = nullptr;  ///< Told every period, skipped ones included.
};

/// A device that now and then answers nothing usable, or whose forces are switched off.
class FlakyDevice : public Device {
 public:
  FlakyDevice(Device* device, std::mt19937* random) : device_(*device), random_(*random) {}

  DeviceSample Read(Nanoseconds now) noexcept override {
    DeviceSample sample = device_.Read(now);
    if (out_ == 0 && random_() % 100 == 0) out_ = static_cast<int>(random_() % 20);
    if (out_ > 0) {
      --out_;
      sample.valid = false;
    }
    forces_off_ = random_() % 300 == 0;
    return sample;
  }
  void Write(const AxisEffort& effort) noexcept override { device_.Write(effort); }
  void Home() override { device_.Home(); }
  void EnableForce(bool on) noexcept override { device_.EnableForce(on); }
  void EmergencyStop() noexcept override { device_.EmergencyStop(); }
  bool ForceOn() const noexcept override { return device_.ForceOn() && !forces_off_; }
  DeviceLimits limits() const noexcept override { return device_.limits(); }

 private:
  Device& device_;
  std::mt19937& random_;
  int out_ = 0;
  bool forces_off_ = false;
};

/// Runs a session of simulated hands on one thread and writes its log.
inline void Record(const Recording& recording) {
  const bool busy = recording.busy_seed != 0;
  std::mt19937 random(recording.busy_seed);
  const auto up_to = [&random](std::uint32_t most) { return random() % (most + 1); };

  Session session(LoadScene(recording.scene));
  session.EnableForces(true);
  std::vector<HapticInstrument> instruments = session.HapticInstruments();
  std::deque<FlakyDevice> flaky;
  constexpr Nanoseconds kMillisecond = 1'000'000;
  for (HapticInstrument& instrument : instruments) {
    for (int ms = 0; ms < recording.hand_lead_ms; ++ms) instrument.device->Read(ms * kMillisecond);
    if (busy) instrument.device = &flaky.emplace_back(instrument.device, &random);
  }
  HapticLoop haptics(
      instruments, session.haptic_period_ns(),
      {session.tool_states, session.patches, session.samples, nullptr, &session.control});
  ControlScript script(recording.wishes);
  // The clock by which relaxations run out of time.
  Nanoseconds busy_time = 0;
  std::function<Nanoseconds()> stopwatch;
  if (busy) stopwatch = [&] { return busy_time += up_to(12) * kMillisecond; };
  DeformationLoop deformation(session.organs(), session.DeformationTools(),
                              {session.tool_states, session.patches, *session.render_scenes,
                               *session.telemetry_scenes, &session.steps},
                              stopwatch);
  TelemetryLoop telemetry(&session.samples, &session.steps, session.telemetry_scenes.get(),
                          recording.log, {}, session.Info());

  struct Begun {
    ToolState tools;
    Nanoseconds time_ns;
    int visible_at;
  };
  std::deque<Begun> begun;
  const Nanoseconds period = session.haptic_period_ns();
  const Nanoseconds start = recording.hand_lead_ms * kMillisecond;
  const int delay = session.scene().timing.patch_delay_ticks;
  const int step_ticks = session.scene().timing.haptic_hz / session.scene().timing.deformation_hz;
  TickTiming timing;
  for (int tick = 0; tick < recording.ticks; ++tick) {
    if (recording.before_tick) recording.before_tick(tick);
    if (busy && up_to(30) == 0) {
      ++(up_to(1) == 0 ? timing.skipped.late_wake_up : timing.skipped.stalled);
      continue;
    }
    while (!begun.empty() && begun.front().visible_at <= tick) {
      deformation.Step(begun.front().tools, begun.front().time_ns);
      begun.pop_front();
    }
    if (busy) timing.wake_late_ns = up_to(900'000);
    const Nanoseconds scheduled = start + tick * period;
    script.Advance(scheduled, &session.control);
    haptics.Tick(static_cast<std::uint64_t>(tick), scheduled, timing);
    timing = {};
    if (tick % step_ticks == 0) {
      // Busy, the next step may begin with the same or be done with this one: then its patch is
      // seen by no tick.
      const int late = busy ? 1 + static_cast<int>(up_to(2) == 0 ? up_to(80) : up_to(10)) : delay;
      const int after = begun.empty() ? 0 : begun.back().visible_at;
      begun.push_back({deformation.NewestTools(), scheduled, std::max(tick + late, after)});
    }
    if (!busy || up_to(20) == 0) telemetry.Drain();
  }
  telemetry.Finish();
}

}  // namespace hpdm
