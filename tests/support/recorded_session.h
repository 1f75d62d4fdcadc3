#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
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
  int hand_lead_ms = 0;  ///< Time that the hands' scripts are ahead of the first tick.
  /// 0 selects the lockstep clock. Another seed simulates a busy machine: ticks late or skipped,
  /// steps of 5 to 80 ms, patches replaced before a tick sees them, devices without valid samples
  /// for a while, relaxations cut short by their clock.
  std::uint32_t busy_seed = 0;
  int output_interval = 1;                         ///< TelemetryOptions::output_interval.
  std::vector<TimedControl> wishes = {};           ///< Scripted session control by time.
  std::function<void(int)> before_tick = nullptr;  ///< Called every period, skipped ones included.
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

/// Runs a session on one thread. Each step ends some ticks after it begins, as on its own thread.
class RecordingBench {
 public:
  explicit RecordingBench(const Recording& recording)
      : recording_(recording),
        random_(recording.busy_seed),
        session_(LoadScene(recording.scene)),
        script_(recording.wishes) {
    session_.EnableForces(true);
    std::vector<HapticInstrument> instruments = session_.HapticInstruments();
    for (HapticInstrument& instrument : instruments) {
      for (int ms = 0; ms < recording.hand_lead_ms; ++ms) {
        instrument.device->Read(ms * kMillisecond);
      }
      if (busy_) instrument.device = &flaky_.emplace_back(instrument.device, &random_);
    }
    haptics_.emplace(instruments, session_.haptic_period_ns(),
                     HapticLoop::Edges{session_.tool_states, session_.patches, session_.samples,
                                       nullptr, &session_.control});
    // The clock by which relaxations run out of time.
    std::function<Nanoseconds()> stopwatch;
    if (busy_) stopwatch = [this] { return busy_time_ += UpTo(12) * kMillisecond; };
    deformation_.emplace(
        session_.organs(), session_.DeformationTools(),
        DeformationEdges{session_.tool_states, session_.patches, *session_.render_scenes,
                         *session_.telemetry_scenes, &session_.steps},
        stopwatch);
    TelemetryOptions options;
    options.output_interval = recording.output_interval;
    telemetry_.emplace(&session_.samples, &session_.steps, session_.telemetry_scenes.get(),
                       recording.log, options, session_.Info());
  }

  void Run() {
    for (int tick = 0; tick < recording_.ticks; ++tick) {
      if (recording_.before_tick) recording_.before_tick(tick);
      if (busy_ && UpTo(30) == 0) {
        ++(UpTo(1) == 0 ? timing_.skipped.late_wake_up : timing_.skipped.stalled);
        continue;
      }
      Tick(tick);
      if (!busy_ || UpTo(20) == 0) telemetry_->Drain();
    }
    telemetry_->Finish();
  }

 private:
  static constexpr Nanoseconds kMillisecond = 1'000'000;

  struct BegunStep {
    ToolState tools;
    Nanoseconds time_ns;
    int visible_at;  // tick
  };

  std::uint32_t UpTo(std::uint32_t max) { return random_() % (max + 1); }

  void Tick(int tick) {
    while (!begun_.empty() && begun_.front().visible_at <= tick) {
      deformation_->Step(begun_.front().tools, begun_.front().time_ns);
      begun_.pop_front();
    }
    if (busy_) timing_.wake_late_ns = UpTo(900'000);
    const Nanoseconds scheduled =
        recording_.hand_lead_ms * kMillisecond + tick * session_.haptic_period_ns();
    script_.Advance(scheduled, &session_.control);
    haptics_->Tick(static_cast<std::uint64_t>(tick), scheduled, timing_);
    timing_ = {};
    const TimingOptions& timing = session_.scene().timing;
    if (tick % (timing.haptic_hz / timing.deformation_hz) == 0) BeginStep(tick, scheduled);
  }

  void BeginStep(int tick, Nanoseconds time) {
    // On a busy machine two steps may end in one tick: no tick sees the patch of the first.
    const int late = busy_ ? 1 + static_cast<int>(UpTo(2) == 0 ? UpTo(80) : UpTo(10))
                           : session_.scene().timing.patch_delay_ticks;
    const int after = begun_.empty() ? 0 : begun_.back().visible_at;
    begun_.push_back({deformation_->NewestTools(), time, std::max(tick + late, after)});
  }

  const Recording recording_;
  const bool busy_ = recording_.busy_seed != 0;
  std::mt19937 random_;
  Session session_;
  ControlScript script_;
  std::deque<FlakyDevice> flaky_;
  std::optional<HapticLoop> haptics_;
  Nanoseconds busy_time_ = 0;
  std::optional<DeformationLoop> deformation_;
  std::optional<TelemetryLoop> telemetry_;
  std::deque<BegunStep> begun_;
  TickTiming timing_;
};

/// Runs a session of simulated hands on one thread and writes its log.
inline void Record(const Recording& recording) { RecordingBench(recording).Run(); }

}  // namespace hpdm
