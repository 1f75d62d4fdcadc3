#include "tools/replay/log_replay.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "engine/base/error.h"
#include "engine/checkpoints.h"
#include "engine/threads/session_clock.h"
#include "haptics/device/replay_device.h"

namespace hpdm {
namespace {

// Passes a step through its message, as the log does: orientations become quaternions.
StepSample AsLogged(const StepSample& sample) {
  contact_t message;
  StepSample logged;
  std::int64_t visible_tick;
  ToMessage(sample, kNeverVisible, &message);
  FromMessage(message, &logged, &visible_tick);
  return logged;
}

// Runs the two production loops on one thread, in the log's order of events.
class Player {
 public:
  Player(const LoggedSession& log, double tolerance, Session* session, ReplayViewer* viewer)
      : log_(log),
        viewer_(viewer),
        session_(*session),
        haptics_(
            Instruments(), session->haptic_period_ns(),
            {session->tool_states, session->patches, session->samples, nullptr, &session->control}),
        checkpoints_(session->ExerciseSteps()),
        deformation_(session->organs(), session->DeformationTools(),
                     {session->tool_states, session->patches, *session->render_scenes,
                      *session->telemetry_scenes, &session->steps, &checkpoints_},
                     nullptr, 0, session->scene().attachments, session->scene().ducts) {
    checkpoints_.MakeRoom(deformation_);
    replay_.comparison = FieldComparison(tolerance);
    replay_.tool_count = static_cast<int>(devices_.size());
    replay_.steps_logged = log.steps().size() + log.steps_unusable();
  }

  LogReplay Run() {
    MeasureLog();
    TickReader ticks(log_.path());
    for (LoggedTick tick; replay_.ended_early.empty() && ticks.Next(&tick);) PlayTick(tick);
    if (replay_.ended_early.empty()) StepThrough(log_.steps().size());
    for (int t = 0; t < replay_.tool_count; ++t) replay_.forces[t] = forces_.Of(t);
    return std::move(replay_);
  }

 private:
  std::vector<HapticInstrument> Instruments() {
    std::vector<HapticInstrument> instruments = session_.HapticInstruments();
    for (HapticInstrument& instrument : instruments) {
      devices_.push_back(std::make_unique<ReplayDevice>(instrument.device->limits()));
      instrument.device = devices_.back().get();
    }
    return instruments;
  }

  void MeasureLog() {
    TickReader ticks(log_.path());
    for (LoggedTick tick; ticks.Next(&tick);) {
      if (tick.sample.tool_count != replay_.tool_count) {
        throw InputError(log_.path() + ": has a tick of " + std::to_string(tick.sample.tool_count) +
                         " instruments, but the scene has " + std::to_string(replay_.tool_count) +
                         "; give the log's own scene with --scene");
      }
      replay_.comparison.Measure(tick.sample, tick.has_output);
      ++replay_.ticks_logged;
      replay_.ticks_lost += tick.lost_before;
    }
    for (const LoggedStep& step : log_.steps()) replay_.comparison.Measure(step.sample);
  }

  void PlayTick(const LoggedTick& logged) {
    const std::string here = "tick " + std::to_string(logged.sample.tick);
    if (logged.lost_before > 0) {
      return EndEarly(std::to_string(logged.lost_before) + " ticks before " + here +
                      " are not in the log");
    }
    // Computes the steps up to the last one that is visible to this tick.
    const std::vector<LoggedStep>& steps = log_.steps();
    std::size_t end = next_step_;
    for (std::size_t i = next_step_; i < steps.size(); ++i) {
      const std::int64_t visible = steps[i].visible_tick;
      if (visible > static_cast<std::int64_t>(logged.sample.tick)) break;
      if (visible >= 0) end = i + 1;
    }
    if (!StepThrough(end)) return;
    if (logged.has_output && logged.sample.patch_number > steps.size()) {
      return EndEarly("step " + std::to_string(steps.size() + 1) + " is not in the log; " + here +
                      " used step " + std::to_string(logged.sample.patch_number));
    }

    for (std::size_t i = 0; i < devices_.size(); ++i) devices_[i]->Set(logged.sample.tools[i]);
    session_.control.Back() = ControlOf(logged.sample);
    session_.control.Publish();
    const Nanoseconds started = ReadClock(CLOCK_MONOTONIC);
    haptics_.Tick(logged.sample.tick, logged.sample.time_ns,
                  {.wake_late_ns = logged.sample.wake_late_ns, .skipped = logged.sample.skipped});
    replay_.tick_compute.Add(ReadClock(CLOCK_MONOTONIC) - started);
    if (next_step_ < steps.size() && Used(logged.sample.tick)) {
      tool_states_[logged.sample.tick] = deformation_.NewestTools();
    }
    HapticSample replayed;
    session_.samples.Pop(&replayed);
    if (viewer_ != nullptr) viewer_->OnTick(replayed);
    replay_.comparison.Compare(logged.sample, replayed, logged.has_output);
    if (logged.has_output) {
      ++replay_.ticks_compared;
      forces_.Add(logged.sample, replayed);
    } else {
      ++replay_.ticks_without_output;
    }
  }

  // True if a later step used the tick's tool state. Input ticks never decrease.
  bool Used(std::uint64_t tick) const {
    const std::vector<LoggedStep>& steps = log_.steps();
    const auto at = std::lower_bound(
        steps.begin() + static_cast<std::ptrdiff_t>(next_step_), steps.end(), tick,
        [](const LoggedStep& step, std::uint64_t t) { return step.sample.step.input_tick < t; });
    return at != steps.end() && at->sample.step.input_tick == tick;
  }

  // Computes and compares the steps before `end`; false if the log lacks a step's input.
  bool StepThrough(std::size_t end) {
    for (; next_step_ < end; ++next_step_) {
      const StepSample& logged = log_.steps()[next_step_].sample;
      const std::uint64_t input = logged.step.input_tick;
      ToolState tools;  // empty before the haptic loop's first tick
      tool_states_.erase(tool_states_.begin(), tool_states_.lower_bound(input));
      const auto at = tool_states_.find(input);
      if (at != tool_states_.end() && (logged.tool_count > 0 || devices_.empty())) {
        tools = at->second;
      } else if (logged.tool_count > 0) {
        EndEarly("tick " + std::to_string(input) + ", which step " +
                 std::to_string(logged.step.number) + " used, is not in the log before it");
        return false;
      }
      deformation_.ApplyRecorded(logged);
      deformation_.Step(tools, logged.step.time_ns);
      StepSample replayed;
      session_.steps.Pop(&replayed);
      replay_.comparison.Compare(logged, AsLogged(replayed));
      ++replay_.steps_compared;
      if (viewer_ != nullptr && !viewer_->OnStep(logged.step.time_ns)) {
        replay_.stopped = true;
        EndEarly("stopped by the user");
        return false;
      }
    }
    return true;
  }

  void EndEarly(std::string why) { replay_.ended_early = std::move(why); }

  const LoggedSession& log_;
  ReplayViewer* viewer_;
  Session& session_;
  std::vector<std::unique_ptr<ReplayDevice>> devices_;
  HapticLoop haptics_;
  Checkpoints checkpoints_;
  DeformationLoop deformation_;
  LogReplay replay_;
  ForceDifferences forces_;
  std::size_t next_step_ = 0;  // steps before it are computed
  std::map<std::uint64_t, ToolState> tool_states_;
};

}  // namespace

SessionControl ControlOf(const HapticSample& sample) {
  SessionControl control{.paused = sample.paused};
  control.restart = sample.restart;
  for (int t = 0; t < sample.tool_count; ++t) {
    control.instrument_index[t] = sample.tools[t].instrument_index;
    control.pedal[t] = sample.tools[t].pedal;
  }
  return control;
}

void ForceDifferences::Add(const HapticSample& logged, const HapticSample& replayed) {
  ++count_;
  for (int t = 0; t < logged.tool_count; ++t) {
    const double difference = (logged.tools[t].force_W - replayed.tools[t].force_W).norm();
    sums_[t].rms += difference * difference;
    sums_[t].peak = std::max(sums_[t].peak, difference);
    sums_[t].logged_peak = std::max(sums_[t].logged_peak, logged.tools[t].force_W.norm());
  }
}

ForceDifference ForceDifferences::Of(int tool) const {
  ForceDifference of = sums_[tool];
  if (count_ > 0) of.rms = std::sqrt(of.rms / static_cast<double>(count_));
  return of;
}

void RequireSameScene(const LoggedSession& log, const Session& session) {
  const std::string why = log.WhyAnother(session.Info());
  if (why.empty()) return;
  throw InputError(log.path() + ": not a log of " + session.scene().path.string() + ": " + why +
                   "; give the log's own scene with --scene");
}

LogReplay ReplayLog(const LoggedSession& log, double tolerance, Session* session,
                    ReplayViewer* viewer) {
  RequireSameScene(log, *session);
  return Player(log, tolerance, session, viewer).Run();
}

}  // namespace hpdm
