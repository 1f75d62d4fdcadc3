#include "lcmtypes/telemetry/telemetry_loop.h"

#include <algorithm>
#include <chrono>
#include <functional>
#include <thread>
#include <utility>

#include "lcmtypes/telemetry/exercise_events.h"
#include "lcmtypes/wire/mesh_codec.h"

namespace hpdm {
namespace {

constexpr std::chrono::milliseconds kPollPeriod(5);
constexpr Nanoseconds kStatisticsPeriod = kNanosecondsPerSecond;

// Samples arrive within kPollPeriod of their tick. If a step is ahead of them by more than this,
// the haptic loop has stopped, and the interval ends without it.
constexpr Nanoseconds kSamplePatience = kNanosecondsPerSecond / 2;

// An unchanged shape is sent again after this time, for receivers that join late or seek in a log.
constexpr Nanoseconds kShapeRepeat = kNanosecondsPerSecond;

// Between two messages about an exercise in which nothing happens.
constexpr Nanoseconds kExercisePeriod = kNanosecondsPerSecond / 10;

}  // namespace

TelemetryLoop::TelemetryLoop(SpscQueue<HapticSample>* samples, SpscQueue<StepSample>* steps,
                             TripleBuffer<SceneSnapshot>* scenes, const std::string& log_path,
                             const TelemetryOptions& options, const SessionInfo& info)
    : samples_(samples),
      steps_(steps),
      scenes_(scenes),
      options_(options),
      live_(options.live, options.mesh_repeat),
      log_({.log_path = log_path,
            .epoch_us = options.epoch_us,
            .timeline_path = options.timeline_path,
            .timeline_interval = options.timeline_interval},
           info.instruments),
      events_(info, std::bind_front(&TelemetryLoop::AddEvent, this), options.tell),
      matcher_([this](contact_t* step) {
        step->sequence = ++contact_sequence_;
        Send(kContactChannel, step->time_ns, *step);
      }),
      statistics_(options.haptic_period, options.baseline),
      health_(options.health),
      stolen_(options.stolen_time ? options.stolen_time() : 0),
      thinning_(options.output_interval),
      logged_shapes_(kMaxOrgans, SentShape(options.output_interval > 1
                                               ? options.output_interval * options.haptic_period
                                               : 0)),
      published_shapes_(kMaxOrgans, SentShape(0)) {
  if (info.exercise) exercise_.emplace(*info.exercise);
  events_.ReportStart(options.baseline);
  if (options.output_interval > 1) {
    AddEvent(EventSeverity::kInfo, std::string(kLogThinned), ThinnedText(options.output_interval));
  }
  WriteMeshes(info.organs);
}

TelemetryLoop::~TelemetryLoop() { Finish(); }

void TelemetryLoop::WriteMeshes(const std::vector<OrganDescription>& organs) {
  std::vector<mesh_t> parts;
  for (std::size_t i = 0; i < organs.size(); ++i) {
    for (mesh_t& part : SplitMesh(static_cast<int>(i), organs[i])) {
      part.sequence = static_cast<std::int64_t>(parts.size()) + 1;
      log_.Write(kMeshChannel, 0, part);
      parts.push_back(std::move(part));
    }
  }
  live_.SetMeshes(std::move(parts));
}

void TelemetryLoop::Drain() noexcept {
  if (finished_) return;
  HapticSample sample;
  while (samples_->Pop(&sample)) Handle(sample);
  StepSample step;
  while (steps_->Pop(&step)) Handle(step);
  if (scenes_->Update()) Handle(scenes_->Front());
  FrameRecord frame;
  while (options_.frames != nullptr && options_.frames->Pop(&frame)) statistics_.Add(frame);
  LoopEvent event;
  for (SpscQueue<LoopEvent>* events : options_.events) {
    while (events->Pop(&event)) events_.Add(event);
  }
  health_.Publish(now_, statistics_.sums(), samples_->Overflows());
  live_.PublishMeshPart(now_);
  log_.Flush(now_);
  ReportFailures();
}

void TelemetryLoop::Run(std::stop_token stop) noexcept {
  while (!stop.stop_requested()) {
    Drain();
    std::this_thread::sleep_for(kPollPeriod);
  }
  Finish();
}

void TelemetryLoop::Finish() noexcept {
  if (finished_) return;
  Drain();
  matcher_.Finish();
  if (!statistics_.interval_empty()) CloseInterval(now_ + options_.haptic_period);
  events_.ReportEnd();
  log_.Close();
  ReportFailures();
  finished_ = true;
}

void TelemetryLoop::AddEvent(EventSeverity severity, const std::string& name,
                             const std::string& text) noexcept {
  ++event_.sequence;
  event_.time_ns = now_;
  event_.severity = static_cast<std::int8_t>(severity);
  event_.name = name;
  event_.text = text;
  Send(kEventChannel, now_, event_);
  if (exercise_) AddExerciseEvent(now_, name, text, &*exercise_);
}

TelemetrySummary TelemetryLoop::Summary() const {
  return {.session = statistics_.Summary(),
          .log = log_.state(),
          .queue_overflows = samples_->Overflows(),
          .step_overflows = steps_->Overflows(),
          .live = options_.live,
          .live_messages = live_.messages(),
          .live_errors = live_.errors(),
          .exercise = exercise_ ? std::optional(exercise_->result()) : std::nullopt,
          .timeline_failure = log_.TimelineFailure()};
}

void TelemetryLoop::Handle(const HapticSample& sample) {
  AdvanceTo(sample.time_ns, 0);
  statistics_.Add(sample);
  ToMessage(sample, &tool_);
  ++tool_.sequence;
  Send(kToolChannel, sample.time_ns, tool_);
  ToMessage(sample, &force_);
  SendOutput(kForceChannel, sample.time_ns, thinning_.Selects(sample), !options_.forces_linked,
             &forces_, &force_);
  events_.Add(sample);
  health_.Add(sample);
  log_.Add(sample);
  if (sample.patch_number > 0) matcher_.AddFirstUse(sample.patch_number, sample.patch_tick);
}

void TelemetryLoop::Handle(const StepSample& sample) {
  health_.Add(sample.step);
  AdvanceTo(sample.step.time_ns, kSamplePatience);
  statistics_.Add(sample.step);
  events_.Add(sample);
  if (exercise_) {
    exercise_->Add(sample);
    events_.Add(*exercise_);
    health_.Add(exercise_->Status());
    SendExercise(sample.step.time_ns);
    SendProgress();
    exercise_ended_.store(exercise_->result().ended, std::memory_order_release);
    bleedings_over_.store(exercise_->BleedingsOver(), std::memory_order_release);
  }
  contact_t contact;
  ToMessage(sample, kNeverVisible, &contact);
  matcher_.AddStep(std::move(contact));
}

// Tells the deformation loop the present step.
void TelemetryLoop::SendProgress() {
  if (options_.progress == nullptr) return;
  options_.progress->Back() = exercise_->Progress();
  options_.progress->Publish();
}

// Sends the exercise's state if a step, an error or the end has come, or a while after the last time.
void TelemetryLoop::SendExercise(Nanoseconds time) {
  const ExerciseStatus status = exercise_->Status();
  const ExerciseOptions& options = exercise_->options();
  exercise_t& message = exercise_message_;
  const bool first = message.sequence == 0;
  const bool changed = message.step != status.step || message.error_count != status.errors ||
                       message.restarts != status.restarts ||
                       message.ended != static_cast<std::int8_t>(status.ended);
  const Nanoseconds period = status.ended ? kShapeRepeat : kExercisePeriod;
  if (!first && !changed && time < message.time_ns + period) return;
  ++message.sequence;
  message.time_ns = time;
  message.step = status.step;
  message.step_count = static_cast<std::int32_t>(options.steps.size());
  message.error_count = status.errors;
  message.progress = status.progress;
  message.time = status.time;
  message.time_left = status.time_left;
  message.score = status.score;
  message.ended = status.ended;
  message.passed = status.passed;
  message.restarts = status.restarts;
  message.name = options.name;
  const auto step = ToSize(status.step);
  message.instruction.clear();
  if (step < options.steps.size()) {
    const ExerciseStepOptions& present = options.steps[step];
    message.instruction = present.instruction.empty() ? present.name : present.instruction;
  }
  if (status.last_error >= 0) {
    message.error_time = status.last_error_time;
    message.last_error = options.errors[ToSize(status.last_error)].name;
  }
  Send(kExerciseChannel, time, message);
}

void TelemetryLoop::Handle(const SceneSnapshot& scene) {
  const StepRecord& step = scene.step;
  for (std::size_t i = 0; i < scene.organs.size(); ++i) {
    const OrganSnapshot& organ = scene.organs[i];
    const bool log = logged_shapes_[i].Update(organ, step);
    const bool publish = options_.live && published_shapes_[i].Update(organ, step);
    if (!log && !publish) continue;
    ToMessage(step, static_cast<int>(i), organ, &organ_);
    SendOutput(kOrganChannel, step.time_ns, log, publish, &shapes_, &organ_);
  }
}

bool TelemetryLoop::SentShape::Update(const OrganSnapshot& organ, const StepRecord& step) {
  if (last_ && last_->version == organ.version && last_->offset_W == organ.offset_W &&
      step.time_ns < last_->time + kShapeRepeat) {
    return false;
  }
  if (last_ && interval_ > 0 && step.time_ns / interval_ == last_->time / interval_) return false;
  last_ = {organ.version, organ.offset_W, step.time_ns};
  return true;
}

/// Closes the interval of whole seconds that ends at or before `time`, once `time` is `patience`
/// beyond its end.
void TelemetryLoop::AdvanceTo(Nanoseconds time, Nanoseconds patience) {
  if (time - patience >= statistics_.interval_start() + kStatisticsPeriod) {
    CloseInterval((time - patience) / kStatisticsPeriod * kStatisticsPeriod);
  }
  now_ = std::max(now_, time);
}

void TelemetryLoop::CountStolenTime() {
  if (!options_.stolen_time) return;
  const Nanoseconds total = options_.stolen_time();
  // The kernel's count may step back by a tick where it changes its mind.
  if (total > stolen_) statistics_.AddStolen(total - stolen_);
  stolen_ = std::max(stolen_, total);
}

void TelemetryLoop::CloseInterval(Nanoseconds end) {
  CountStolenTime();
  statistics_.CloseInterval(end, &stats_);
  ++stats_.sequence;
  health_.Add(stats_);
  const std::uint64_t overflows = samples_->Overflows();
  if (options_.frames != nullptr) {
    const std::uint64_t frames_missed = options_.frames->Overflows();
    stats_.render.missed = static_cast<std::int64_t>(frames_missed - frames_missed_);
    frames_missed_ = frames_missed;
  }
  stats_.queue_overflows = static_cast<std::int64_t>(overflows);
  stats_.log_events = static_cast<std::int64_t>(log_.state().events);
  stats_.log_dropped = static_cast<std::int64_t>(log_.state().dropped);
  stats_.live_errors = static_cast<std::int64_t>(live_.errors());
  Send(kStatsChannel, end, stats_);
  events_.AddLosses(overflows, stats_.deformation.missed);
}

/// A failed log does not stop the live messages, so its event still reaches listeners.
void TelemetryLoop::ReportFailures() {
  events_.AddFailures(log_.state(), log_.TimelineFailure(), live_.errors());
}

template <typename Message>
void TelemetryLoop::Send(const char* channel, Nanoseconds time, const Message& message) {
  live_.Publish(channel, log_.Write(channel, time, message));
}

/// Log and network number their messages separately, so that neither seems to lack what it was not
/// sent.
template <typename Message>
void TelemetryLoop::SendOutput(const char* channel, Nanoseconds time, bool log, bool publish,
                               OutputCounts* counts, Message* message) {
  if (log) {
    message->sequence = ++counts->logged;
    log_.Write(channel, time, *message);
  }
  if (publish && options_.live) {
    message->sequence = ++counts->published;
    live_.Publish(channel, EncodeMessage(*message, &live_buffer_));
  }
}

}  // namespace hpdm
