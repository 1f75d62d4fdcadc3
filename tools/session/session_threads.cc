#include "tools/session/session_threads.h"

#include <latch>
#include <optional>
#include <stop_token>
#include <thread>
#include <utility>
#include <vector>

#include "engine/base/error.h"
#include "engine/threads/loop_schedule.h"
#include "tools/session/crash_stop.h"
#include "tools/session/lockstep.h"
#include "tools/session/realtime_threads.h"

namespace hpdm {
namespace {

constexpr Nanoseconds kBaselineLength = kNanosecondsPerSecond;
// Longest wait for a window's input, s. Held keys act at this period.
constexpr double kWindowPeriod = 0.01;

// Starts the two threads of the link to external devices; none without a link.
std::vector<std::jthread> StartLink(DeviceLink* link) {
  std::vector<std::jthread> threads;
  if (link == nullptr) return threads;
  for (const auto work : {&DeviceLink::Receive, &DeviceLink::Send}) {
    threads.emplace_back([link, work](std::stop_token stop) {
      RealtimeOptions realtime;
      realtime.fifo_priority = DeviceLink::kPriority;
      RequestRealtime(realtime);
      (link->*work)(stop);
    });
  }
  return threads;
}

// True once the scene's exercise is over and no window shows its result. In a window the session then
// pauses until the user ends it.
bool ExerciseOver(const Loops& loops, bool has_window, bool* ended) {
  if (!loops.telemetry.ExerciseEnded()) return false;
  if (!has_window) return true;
  if (!std::exchange(*ended, true)) loops.window->SetPaused(true);
  return false;
}

// Does what the teacher has asked for.
void HearTeacher(const Loops& loops, Nanoseconds now, bool has_window) {
  if (loops.teacher == nullptr) return;
  const auto [pause, restart_step] = loops.teacher->Handle(now, loops.telemetry.BleedingsOver());
  const bool restarts =
      restart_step && loops.session.ExerciseSteps() > 0 && !loops.telemetry.ExerciseEnded();
  if (has_window) {
    if (pause) loops.window->SetPaused(*pause);
    if (restarts) loops.window->Restart(*restart_step);
  } else {
    if (pause) loops.exchanges->SetPaused(*pause, &loops.session.control);
    if (restarts) loops.exchanges->Restart(*restart_step, &loops.session.control);
  }
}

// Handles the window's input, or without a window the controls of the command line, until `over`,
// until the user ends the session or the exercise is over. Notes in the record who ended it.
void PassOnControls(const Loops& loops, const SessionClock& clock, const std::stop_source& over,
                    RunRecord* record) {
  bool has_window = loops.window != nullptr;
  bool& ended = record->ended_by_user;
  bool exercise_ended = false;
  while (!over.stop_requested() && !ended && !record->ended_by_exercise) {
    record->ended_by_exercise = ExerciseOver(loops, has_window, &exercise_ended);
    HearTeacher(loops, clock.Now(), has_window);
    if (has_window && loops.window->lost()) {
      loops.window->Resume();
      has_window = false;
      if (loops.tone != nullptr) loops.tone->Sound(false);
    }
    if (has_window) {
      loops.window->Pump(kWindowPeriod);
      const bool burns = loops.render.burns() && !loops.window->paused();
      if (loops.tone != nullptr) loops.tone->Sound(burns);
      ended = loops.window->ended() || loops.signals.WaitFor(0);
    } else {
      loops.exchanges->Advance(clock.Now(), &loops.session.control);
      ended = loops.signals.WaitFor(20'000'000);
    }
  }
  // The key that closes the result does not end the session earlier than the exercise.
  if (exercise_ended) {
    record->ended_by_exercise = true;
    ended = false;
  }
  if (loops.tone != nullptr) loops.tone->Sound(false);
}

void End(std::jthread* thread) {
  if (!thread->joinable()) return;
  thread->request_stop();
  thread->join();
}

}  // namespace

MachineState ProbeRealtime(bool lockstep, bool require_realtime, Nanoseconds period_ns) {
  MachineState machine;
  if (lockstep && !require_realtime) return machine;
  machine.process = RequestRealtime(ProcessRealtime());
  std::jthread([&] {
    machine.haptic = RequestRealtime(HapticRealtime());
    if (lockstep || (require_realtime && !machine.Refusal().empty())) return;
    RealLoopClock clock{SessionClock()};
    const auto ticks = static_cast<std::uint64_t>(kBaselineLength / period_ns);
    machine.baseline = MeasureWakeUps({period_ns, period_ns, ticks}, {}, clock);
  }).join();
  if (require_realtime && !machine.Refusal().empty()) {
    throw MachineError("--require-rt: " + machine.Refusal() +
                       "; run as root or raise the rtprio and memlock limits");
  }
  return machine;
}

RunRecord RunOnRealClock(const Loops& loops, const MachineState& machine,
                         const SessionClock& clock) {
  RunRecord record;
  record.baseline = machine.baseline;
  RealtimeReport haptic, deformation;
  const CrashStop crash_stop(&loops.haptics);
  std::optional<ForcesOn> forces(std::in_place, &loops.session);
  std::latch start(loops.pictures ? 3 : 2);
  std::stop_source over;
  std::vector<std::jthread> link_threads = StartLink(loops.link);
  std::jthread telemetry_thread([&](std::stop_token stop) { loops.telemetry.Run(stop); });
  std::jthread render_thread;
  if (loops.pictures) {
    render_thread = std::jthread([&](std::stop_token stop) {
      loops.render.TryToStart();
      start.arrive_and_wait();
      loops.render.Run(stop);
    });
  }
  std::jthread deformation_thread([&](std::stop_token stop) {
    deformation = RequestRealtime(DeformationRealtime());
    start.arrive_and_wait();
    RealLoopClock loop_clock(clock);
    const int hz = loops.session.scene().timing.deformation_hz;
    record.deformation = RunOnSchedule(
        {.start_ns = clock.Now(), .period_ns = kNanosecondsPerSecond / hz}, stop, loop_clock,
        [&](std::uint64_t, Nanoseconds due, const TickTiming& timing) {
          loops.deformation.Step(loops.deformation.NewestTools(), due, timing.wake_late_ns);
        });
  });
  std::jthread haptic_thread([&](std::stop_token stop) {
    haptic = RequestRealtime(HapticRealtime());
    start.arrive_and_wait();
    RealLoopClock loop_clock(clock);
    record.haptic = loops.haptics.RunRealClock(stop, loop_clock, clock.Now(), loops.end_tick);
    over.request_stop();
  });
  PassOnControls(loops, clock, over, &record);
  // The forces first: the other threads may take long to end.
  End(&haptic_thread);
  forces.reset();
  for (std::jthread* thread : {&deformation_thread, &render_thread, &telemetry_thread}) {
    End(thread);
  }
  for (std::jthread& thread : link_threads) End(&thread);
  if (loops.link != nullptr) record.link = loops.link->Summary();
  record.realtime = {
      {"process", machine.process}, {"haptic", haptic}, {"deformation", deformation}};
  return record;
}

RunRecord RunInLockstep(const Loops& loops) {
  RunRecord record;
  record.lockstep = true;
  const TimingOptions& timing = loops.session.scene().timing;
  Lockstep clock(timing, &loops.haptics, &loops.deformation);
  const CrashStop crash_stop(&loops.haptics);
  std::optional<ForcesOn> forces(std::in_place, &loops.session);
  while (clock.tick() < loops.end_tick && !record.ended_by_user && !record.ended_by_exercise) {
    // Drains every second: the queue holds two seconds of samples, and steps may be rarer.
    if (clock.tick() % static_cast<std::uint64_t>(timing.haptic_hz) == 0) loops.telemetry.Drain();
    if (clock.StepIfDue()) {
      ++record.deformation.ticks;
      if (loops.pictures) loops.render.Frame();
      loops.telemetry.Drain();
      record.ended_by_user = loops.signals.WaitFor(0);
      record.ended_by_exercise = loops.telemetry.ExerciseEnded();
    }
    loops.exchanges->Advance(
        static_cast<Nanoseconds>(clock.tick()) * loops.session.haptic_period_ns(),
        &loops.session.control);
    clock.Tick();
    ++record.haptic.ticks;
  }
  clock.RampOut();
  forces.reset();
  loops.telemetry.Finish();
  loops.render.EndOnThisThread();
  return record;
}

}  // namespace hpdm
