// Tests the forces that a session's devices display at its end.

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "tests/support/liver_scene.h"
#include "tests/support/scratch_folder.h"
#include "tools/session/crash_stop.h"
#include "tools/session/session_threads.h"

namespace hpdm {
namespace {

constexpr char kForceOff[] = "the device's force is off";
constexpr double kPress = 1;  // N, of an effort: the hand presses with 2.5 to 5 N

/// Records the efforts written to a session's device. Prints to stderr when it is stopped.
class WatchedDevice : public Device {
 public:
  explicit WatchedDevice(Device* device) : device_(*device) { efforts.reserve(100'000); }

  DeviceSample Read(Nanoseconds now) noexcept override { return device_.Read(now); }
  void Write(const AxisEffort& effort) noexcept override {
    device_.Write(effort);
    displayed = effort.norm();
    if (efforts.size() < efforts.capacity()) efforts.push_back(effort);
  }
  void Home() override { device_.Home(); }
  void EnableForce(bool on) noexcept override { device_.EnableForce(on); }
  void EmergencyStop() noexcept override {
    device_.EmergencyStop();
    [[maybe_unused]] const auto written = write(STDERR_FILENO, kForceOff, sizeof kForceOff - 1);
  }
  bool ForceOn() const noexcept override { return device_.ForceOn(); }
  DeviceLimits limits() const noexcept override { return device_.limits(); }

  std::atomic<double> displayed = 0;  // any thread
  std::vector<AxisEffort> efforts;    // the device's owner

 private:
  Device& device_;
};

/// Writes a scene whose hand presses a coarse liver for six tenths of every second, and loads it.
Scene PressingScene(const ScratchFolder& folder) {
  const std::string path = folder / "scene.toml";
  std::ofstream(path) << kMetricLiver + kRearSupport + kPalpatingProbe + "  depth = 0.025\n";
  return LoadScene(path);
}

/// A session of that scene without pictures.
class PressingSession {
 public:
  PressingSession() : session_(PressingScene(folder_)) {
    HapticInstrument instrument = session_.HapticInstruments()[0];
    device = std::make_unique<WatchedDevice>(instrument.device);
    instrument.device = device.get();
    haptics_ = std::make_unique<HapticLoop>(
        std::vector{instrument}, session_.haptic_period_ns(),
        HapticLoop::Edges{session_.tool_states, session_.patches, session_.samples});
    deformation_ = std::make_unique<DeformationLoop>(
        session_.organs(), session_.DeformationTools(),
        DeformationEdges{session_.tool_states, session_.patches, *session_.render_scenes,
                         *session_.telemetry_scenes, &session_.steps});
    render_ = std::make_unique<RenderLoop>(
        session_.OrganVisuals(), session_.InstrumentVisuals(), session_.scene().laparoscope,
        RenderOptions{}, RenderLoop::Edges{*session_.render_scenes}, [] { return Nanoseconds{0}; });
    TelemetryOptions options;
    options.haptic_period = session_.haptic_period_ns();
    options.stolen_time = [this] { return AsTelemetryCloses(); };
    telemetry_ = std::make_unique<TelemetryLoop>(&session_.samples, &session_.steps,
                                                 session_.telemetry_scenes.get(), folder_ / "log",
                                                 options, session_.Info());
  }

  RunRecord Run(std::uint64_t end_tick) { return RunOnRealClock(LoopsUntil(end_tick), {}, clock_); }
  RunRecord RunLockstep(std::uint64_t end_tick) { return RunInLockstep(LoopsUntil(end_tick)); }
  std::uint64_t LoggedTicks() const { return telemetry_->Summary().session.ticks; }
  bool ForceOn() const { return device->ForceOn(); }
  // Any thread; returns after 20 s without a press too.
  void AwaitPress() const {
    for (int ms = 0; ms < 20'000 && device->displayed < kPress; ++ms) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }

  std::unique_ptr<WatchedDevice> device;
  bool crash = false;                        // the telemetry thread, at a press
  double displayed_as_telemetry_ended = -1;  // N

 private:
  Loops LoopsUntil(std::uint64_t end_tick) {
    return {session_, *haptics_, *deformation_, *render_, *telemetry_, nullptr,
            signals_, end_tick,  false,         nullptr,  &exchanges_};
  }

  // The telemetry asks for the stolen time when it closes a second, and at last in Finish.
  Nanoseconds AsTelemetryCloses() {
    displayed_as_telemetry_ended = device->displayed;
    if (!crash) return 0;
    AwaitPress();
    throw std::runtime_error("a fault of the test's");
  }

  const ScratchFolder folder_;
  const StopSignals signals_;  // before any thread
  Session session_;
  const SessionClock clock_;
  ControlScript exchanges_;
  std::unique_ptr<HapticLoop> haptics_;
  std::unique_ptr<DeformationLoop> deformation_;
  std::unique_ptr<RenderLoop> render_;
  std::unique_ptr<TelemetryLoop> telemetry_;
};

class StoppedSession : public testing::TestWithParam<int> {};

TEST_P(StoppedSession, ShowsNoForceBeforeItsTelemetryEnds) {
  PressingSession session;
  double displayed_at_signal = 0;
  std::jthread person([&] {
    session.AwaitPress();
    displayed_at_signal = session.device->displayed;
    kill(getpid(), GetParam());
  });
  const RunRecord record = session.Run(std::numeric_limits<std::uint64_t>::max());
  person.join();
  EXPECT_TRUE(record.ended_by_user);
  EXPECT_GT(displayed_at_signal, kPress / 2);
  EXPECT_EQ(session.displayed_as_telemetry_ended, 0);
  EXPECT_EQ(session.device->efforts.back(), AxisEffort::Zero());
  EXPECT_FALSE(session.ForceOn());
  // The ramp-out is not counted: the log has the ticks before it.
  EXPECT_EQ(session.LoggedTicks(), record.haptic.ticks);
  EXPECT_GT(session.device->efforts.size(), record.haptic.ticks);
}

INSTANTIATE_TEST_SUITE_P(ByASignal, StoppedSession, testing::Values(SIGINT, SIGTERM, SIGHUP));

TEST(EndedSession, ShowsNoForceAfterItsLastTickInLockstep) {
  PressingSession whole;
  whole.RunLockstep(600);
  std::size_t pressed = 0;
  while (pressed < whole.device->efforts.size() && whole.device->efforts[pressed].norm() < kPress) {
    ++pressed;
  }
  ASSERT_LT(pressed, 600u);

  PressingSession session;
  const RunRecord record = session.RunLockstep(pressed + 1);
  EXPECT_EQ(record.haptic.ticks, pressed + 1);
  EXPECT_EQ(session.LoggedTicks(), pressed + 1);
  const std::vector<AxisEffort>& efforts = session.device->efforts;
  ASSERT_GT(efforts.size(), pressed + 1);
  EXPECT_EQ(efforts[pressed], whole.device->efforts[pressed]);
  EXPECT_EQ(efforts.back(), AxisEffort::Zero());
  EXPECT_EQ(session.displayed_as_telemetry_ended, 0);
  EXPECT_FALSE(session.ForceOn());
}

// The machine's timing decides at which point of a press the session ends.
TEST(EndedSession, ShowsNoForceAfterItsLastTickOnTheRealClock) {
  PressingSession session;
  const RunRecord record = session.Run(800);
  EXPECT_FALSE(record.ended_by_user);
  EXPECT_EQ(record.haptic.Periods(), 800u);
  EXPECT_EQ(session.device->efforts.back(), AxisEffort::Zero());
  EXPECT_EQ(session.displayed_as_telemetry_ended, 0);
  EXPECT_FALSE(session.ForceOn());
}

TEST(EndedSession, AnOwnersExceptionSwitchesTheForcesOff) {
  const ScratchFolder folder;
  Session session(PressingScene(folder));
  const Device& device = *session.HapticInstruments()[0].device;
  try {
    const ForcesOn forces(&session);
    EXPECT_TRUE(device.ForceOn());
    throw std::runtime_error("a fault of the test's");
  } catch (const std::runtime_error&) {
    EXPECT_FALSE(device.ForceOn());
  }
}

// --- Crashes, each in a separate process
// -----------------------------------------------------------

class CrashedSession : public testing::Test {
 protected:
  CrashedSession() { GTEST_FLAG_SET(death_test_style, "threadsafe"); }
};

TEST_F(CrashedSession, TakesTheForceAwayWhenAThreadEndsIt) {
  EXPECT_EXIT(
      {
        PressingSession session;
        session.crash = true;
        session.Run(std::numeric_limits<std::uint64_t>::max());
      },
      testing::KilledBySignal(SIGABRT), kForceOff);
}

/// A loop with one device.
struct OneDevice {
  OneDevice() {
    device.Home();
    device.EnableForce(true);
  }
  class Still : public Device {
   public:
    DeviceSample Read(Nanoseconds now) noexcept override { return {.time_ns = now}; }
    void Write(const AxisEffort&) noexcept override {}
    void Home() override { force_.Home(); }
    void EnableForce(bool on) noexcept override { force_.Enable(on); }
    void EmergencyStop() noexcept override { force_.EmergencyStop(); }
    bool ForceOn() const noexcept override { return force_.On(); }
    DeviceLimits limits() const noexcept override { return {}; }

   private:
    ForceSwitch force_;
  } still;
  WatchedDevice device{&still};
  TripleBuffer<ToolState> tool_states;
  TripleBuffer<ContactPatch> patches;
  SpscQueue<HapticSample> samples{4};
  HapticLoop loop{{{&device, {Vector3d(0, 0, 0.1), -Vector3d::UnitZ(), {}}}},
                  1'000'000,
                  {tool_states, patches, samples}};
};

void CrashBy(void (*crash)()) {
  OneDevice one;
  const CrashStop stop(&one.loop);
  crash();
}

TEST_F(CrashedSession, TakesTheForceAwayWhateverEndsIt) {
  EXPECT_EXIT(CrashBy([] { std::abort(); }), testing::KilledBySignal(SIGABRT), kForceOff);
  EXPECT_EXIT(CrashBy([] { std::thread([] { throw 1; }).join(); }),
              testing::KilledBySignal(SIGABRT), kForceOff);
  EXPECT_EXIT(CrashBy([] { raise(SIGQUIT); }), testing::KilledBySignal(SIGQUIT), kForceOff);
  EXPECT_EXIT(CrashBy([] { std::exit(3); }), testing::ExitedWithCode(3), kForceOff);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // which take it for themselves
  EXPECT_EXIT(CrashBy([] { *static_cast<volatile int*>(nullptr) = 1; }),
              testing::KilledBySignal(SIGSEGV), kForceOff);
#endif
}

TEST_F(CrashedSession, LeavesOthersSignalsAndTheTimeAfterItAlone) {
  OneDevice one;
  signal(SIGUSR1, SIG_IGN);
  {
    const CrashStop stop(&one.loop);
    raise(SIGUSR1);
  }
  EXPECT_TRUE(one.device.ForceOn());
  struct sigaction action = {};
  sigaction(SIGQUIT, nullptr, &action);
  EXPECT_EQ(action.sa_handler, SIG_DFL);
  sigaction(SIGUSR1, nullptr, &action);
  EXPECT_EQ(action.sa_handler, SIG_IGN);
}

}  // namespace
}  // namespace hpdm
