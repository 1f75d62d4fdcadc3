#include "lcmtypes/telemetry/telemetry_loop.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <lcm/lcm-cpp.hpp>
#include <thread>

#include "engine/base/error.h"
#include "engine/base/text_list.h"

namespace hpdm {
namespace {

constexpr std::chrono::milliseconds kPollPeriod(5);
constexpr Nanoseconds kStatisticsPeriod = kNanosecondsPerSecond;
constexpr Nanoseconds kHealthPeriod = kNanosecondsPerSecond / 10;
constexpr Nanoseconds kFlushPeriod = kNanosecondsPerSecond / 10;

// Samples reach the telemetry within a poll of their tick; a step this much ahead of them means
// that the haptic loop has stopped, and the interval is closed without it.
constexpr Nanoseconds kSamplePatience = kNanosecondsPerSecond / 2;

// Steps that may wait for their first use: at least a second at any rate, far beyond any hand-over.
// While the haptic loop stands still, older ones are replaced before a tick can use them.
constexpr std::size_t kMaxWaiting = 1024;

// A shape that stays is sent again as often: who joins late, or seeks in a log, has it by then.
constexpr Nanoseconds kShapeRepeat = kNanosecondsPerSecond;

// An organ at the border of what its tissue can do is one event, not one a step.
constexpr Nanoseconds kSoundAgain = kNanosecondsPerSecond / 4;

std::string Joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) AppendToList(name, &text);
  return text;
}

}  // namespace

std::string SessionStartText(const SessionInfo& info) {
  return "instruments: " + Joined(info.instruments);
}

TelemetryLoop::TelemetryLoop(SpscQueue<HapticSample>* samples, SpscQueue<StepSample>* steps,
                             TripleBuffer<SceneSnapshot>* scenes, const std::string& log_path,
                             const TelemetryOptions& options, const SessionInfo& info)
    : samples_(samples),
      steps_(steps),
      scenes_(scenes),
      options_(options),
      live_(options.live ? Connect(NetworkUrl(), "--live") : nullptr),
      log_(log_path, options.epoch_us),
      statistics_(options.haptic_period, options.baseline),
      instruments_(info.instruments),
      held_(info.held),
      stolen_(options.stolen_time ? options.stolen_time() : 0) {
  if (!options.timeline_path.empty()) {
    timeline_.emplace(options.timeline_path, options.timeline_interval, info.instruments);
  }
  AddEvent(EventSeverity::kInfo, "session.start", SessionStartText(info));
  if (options.baseline.count() > 0) {
    char text[120];
    std::snprintf(text, sizeof text, "an empty loop woke late by %.1f us (p99), %.1f us at most",
                  static_cast<double>(options.baseline.Percentile(0.99)) / 1000,
                  static_cast<double>(options.baseline.max()) / 1000);
    AddEvent(EventSeverity::kInfo, "realtime.baseline", text);
  }
  for (std::size_t i = 0; i < info.organs.size(); ++i) {
    organs_.push_back(info.organs[i].name);
    for (mesh_t& part : SplitMesh(static_cast<int>(i), info.organs[i])) {
      mesh_parts_.push_back(std::move(part));
    }
  }
  std::int64_t sequence = 0;
  for (mesh_t& part : mesh_parts_) {
    part.sequence = ++sequence;
    log_.Write(kMeshChannel, 0, EncodeMessage(part, &buffer_));
  }
  if (!live_) mesh_parts_.clear();
}

TelemetryLoop::~TelemetryLoop() { Finish(); }

void TelemetryLoop::Drain() noexcept {
  if (finished_) return;
  HapticSample sample;
  while (samples_->Pop(&sample)) HandleSample(sample);
  StepSample step;
  while (steps_->Pop(&step)) HandleStep(step);
  if (scenes_->Update()) HandleShapes(scenes_->Front());
  FrameRecord frame;
  while (options_.frames != nullptr && options_.frames->Pop(&frame)) statistics_.Add(frame);
  LoopEvent event;
  for (SpscQueue<LoopEvent>* events : options_.events) {
    while (events->Pop(&event)) {
      AddEvent(event.severity, event.name.data(), event.text.data());
      if (event.severity > EventSeverity::kInfo && options_.tell) options_.tell(event.text.data());
    }
  }
  PublishHealth();
  PublishMeshPart();
  if (now_ - last_flush_ >= kFlushPeriod) {
    log_.Flush();
    if (timeline_) timeline_->Flush();
    last_flush_ = now_;
  }
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
  for (contact_t& contact : waiting_) WriteContact(&contact, kNeverVisible);
  waiting_.clear();
  if (!statistics_.interval_empty()) CloseInterval(now_ + options_.haptic_period);
  AddEvent(EventSeverity::kInfo, "session.end", "the session was closed");
  if (timeline_) timeline_->Close();
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
}

TelemetrySummary TelemetryLoop::Summary() const {
  TelemetrySummary summary;
  summary.session = statistics_.Summary();
  summary.log = log_.state();
  summary.queue_overflows = samples_->Overflows();
  summary.step_overflows = steps_->Overflows();
  summary.live = options_.live;
  summary.live_messages = live_messages_;
  summary.live_errors = live_errors_;
  if (timeline_) summary.timeline_failure = timeline_->Explain();
  return summary;
}

void TelemetryLoop::HandleSample(const HapticSample& sample) {
  AdvanceTo(sample.time_ns, 0);
  statistics_.Add(sample);
  ToMessage(sample, &tool_);
  ++tool_.sequence;
  Send(kToolChannel, sample.time_ns, tool_);
  ToMessage(sample, &force_);
  ++force_.sequence;
  Send(kForceChannel, sample.time_ns, force_, !options_.forces_linked);
  ReportDevices(sample);
  ReportControl(sample);
  health_.tool_count = sample.tool_count;
  for (int i = 0; i < sample.tool_count; ++i) {
    const ToolSample& tool = sample.tools[i];
    health_.tools[i].force_W = tool.force_W;
    health_.tools[i].depth = tool.depth;
    health_.tools[i].organ = tool.organ;
    health_.tools[i].guard_flags = tool.guard_flags;
  }
  if (timeline_) timeline_->Add(sample);
  if (sample.patch_number > 0) ResolveVisible(sample.patch_number, sample.patch_tick);
}

void TelemetryLoop::ReportDevices(const HapticSample& sample) {
  for (std::size_t i = 0; i < instruments_.size() && static_cast<int>(i) < sample.tool_count; ++i) {
    const bool lost = !sample.tools[i].device_valid;
    if (lost == device_lost_[i]) continue;
    device_lost_[i] = lost;
    if (lost) {
      AddEvent(EventSeverity::kWarning, "device.lost",
               instruments_[i] + ": device lost: pose held, force fading out");
    } else {
      AddEvent(EventSeverity::kInfo, "device.back",
               instruments_[i] + ": device back: force fading in");
    }
  }
}

void TelemetryLoop::ReportControl(const HapticSample& sample) {
  if (sample.paused != control_.paused) {
    control_.paused = sample.paused;
    if (sample.paused) {
      AddEvent(EventSeverity::kInfo, "session.paused",
               "session paused: hands held, forces fading out");
    } else {
      AddEvent(EventSeverity::kInfo, "session.resumed", "session resumed, forces fading in");
    }
  }
  for (std::size_t i = 0; i < held_.size() && static_cast<int>(i) < sample.tool_count; ++i) {
    const int instrument_index = sample.tools[i].instrument_index;
    if (instrument_index == control_.instrument_index[i]) continue;
    control_.instrument_index[i] = instrument_index;
    const auto at = static_cast<std::size_t>(instrument_index);
    AddEvent(EventSeverity::kInfo, "instrument.exchanged",
             instruments_[i] + ": the hand holds " +
                 (at < held_[i].size() ? held_[i][at] : std::to_string(instrument_index)) + " now");
  }
}

void TelemetryLoop::HandleStep(const StepSample& sample) {
  const StepRecord& step = sample.step;
  health_.step_compute_ns = step.compute_ns;
  health_.step_flags = step.flags;
  AdvanceTo(step.time_ns, kSamplePatience);
  statistics_.Add(step);
  ReportOrgans(sample);
  ReportShedding(step.shed_level);
  while (!first_uses_.empty() && first_uses_.front().first < step.number) first_uses_.pop_front();

  contact_t contact;
  ToMessage(sample, kNeverVisible, &contact);
  if (!first_uses_.empty() && first_uses_.front().first == step.number) {
    WriteContact(&contact, static_cast<std::int64_t>(first_uses_.front().second));
    first_uses_.pop_front();
  } else if (step.number < newest_used_) {
    WriteContact(&contact, kNeverVisible);
  } else {
    waiting_.push_back(std::move(contact));
    if (waiting_.size() <= kMaxWaiting) return;
    WriteContact(&waiting_.front(), kNeverVisible);
    waiting_.pop_front();
  }
}

void TelemetryLoop::ReportOrgans(const StepSample& sample) {
  const auto count = std::min(organs_.size(), static_cast<std::size_t>(sample.organ_count));
  for (std::size_t o = 0; o < count; ++o) {
    const bool recovering = sample.organs[o].recovering;
    if (sample.organs[o].inverted || recovering) {
      organ_unsound_last_[o] = sample.step.time_ns;
      if (organ_unsound_[o]) continue;
      organ_unsound_[o] = true;
      AddEvent(EventSeverity::kWarning, "organ.inverted",
               organs_[o] + (recovering ? ": its tools ask for more than its tissue can do; it "
                                          "follows them as far as it stays sound"
                                        : ": tissue is turned inside out; picture and forces there "
                                          "are not valid"));
    } else if (organ_unsound_[o] && sample.step.time_ns - organ_unsound_last_[o] >= kSoundAgain) {
      organ_unsound_[o] = false;
      AddEvent(EventSeverity::kInfo, "organ.recovered",
               organs_[o] + ": its tissue is sound again and follows its tools");
    }
  }
}

void TelemetryLoop::ReportShedding(int level) {
  if (level == shed_level_) return;
  if (level > shed_level_) {
    AddEvent(EventSeverity::kWarning, "steps.shed",
             "deformation steps take longer than their budget: reduced quality (level " +
                 std::to_string(level) + ")");
  } else if (level > 0) {
    AddEvent(
        EventSeverity::kInfo, "steps.raised",
        "deformation steps have time again: better quality (level " + std::to_string(level) + ")");
  } else {
    AddEvent(EventSeverity::kInfo, "steps.restored",
             "deformation steps have time again: full quality");
  }
  shed_level_ = level;
}

void TelemetryLoop::HandleShapes(const SceneSnapshot& scene) {
  const StepRecord& step = scene.step;
  for (std::size_t i = 0; i < scene.organs.size(); ++i) {
    const OrganSnapshot& organ = scene.organs[i];
    std::optional<SentShape>& sent = sent_[i];
    if (sent && sent->version == organ.version && sent->offset_W == organ.offset_W &&
        step.time_ns < sent->time + kShapeRepeat) {
      continue;
    }
    sent = {organ.version, organ.offset_W, step.time_ns};
    ToMessage(step, static_cast<int>(i), organ, &organ_);
    ++organ_.sequence;
    Send(kOrganChannel, step.time_ns, organ_);
  }
}

/// Tick `tick` was the first to use the patch of step `patch_number`: steps before that one which
/// still wait were replaced unused.
void TelemetryLoop::ResolveVisible(std::uint64_t patch_number, std::uint64_t tick) {
  if (patch_number <= newest_used_) return;
  newest_used_ = patch_number;
  bool resolved = false;
  while (!waiting_.empty() && static_cast<std::uint64_t>(waiting_.front().step) <= patch_number) {
    resolved = static_cast<std::uint64_t>(waiting_.front().step) == patch_number;
    WriteContact(&waiting_.front(), resolved ? static_cast<std::int64_t>(tick) : kNeverVisible);
    waiting_.pop_front();
  }
  if (!resolved) first_uses_.emplace_back(patch_number, tick);
}

void TelemetryLoop::WriteContact(contact_t* message, std::int64_t visible_tick) {
  message->visible_tick = visible_tick;
  message->sequence = ++contact_sequence_;
  Send(kContactChannel, message->time_ns, *message);
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
  health_.haptic_hz = stats_.haptic.rate_hz;
  health_.deformation_hz = stats_.deformation.rate_hz;
  health_.wake_late_p99_ns =
      stats_.latencies[static_cast<std::size_t>(Latency::kHapticWakeUp)].p99_ns;
  const std::uint64_t overflows = samples_->Overflows();
  if (options_.frames != nullptr) {
    const std::uint64_t frames_missed = options_.frames->Overflows();
    stats_.render.missed = static_cast<std::int64_t>(frames_missed - frames_missed_);
    frames_missed_ = frames_missed;
  }
  stats_.queue_overflows = static_cast<std::int64_t>(overflows);
  stats_.log_events = static_cast<std::int64_t>(log_.state().events);
  stats_.log_dropped = static_cast<std::int64_t>(log_.state().dropped);
  stats_.live_errors = static_cast<std::int64_t>(live_errors_);
  Send(kStatsChannel, end, stats_);
  if (overflows > overflows_reported_) {
    AddEvent(EventSeverity::kWarning, "telemetry.overflow",
             std::to_string(overflows - overflows_reported_) +
                 " ticks found the telemetry queue full and are not in the log");
    overflows_reported_ = overflows;
  }
  if (stats_.deformation.missed > 0) {
    AddEvent(EventSeverity::kWarning, "telemetry.steps_lost",
             std::to_string(stats_.deformation.missed) +
                 " deformation steps found the telemetry queue full and are not in the log");
  }
}

void TelemetryLoop::PublishHealth() {
  if (options_.health == nullptr || now_ < health_.time_ns + kHealthPeriod) return;
  const SessionSummary& sums = statistics_.sums();
  health_.time_ns = now_;
  health_.ticks = sums.ticks;
  health_.skipped = sums.skipped;
  health_.log_lost = samples_->Overflows();
  for (int i = 0; i < health_.tool_count; ++i)
    health_.tools[i].peak_force = sums.tools[i].peak_force;
  options_.health->Back() = health_;
  options_.health->Publish();
}

/// One part a call at most, so that the meshes never crowd out the ticks.
void TelemetryLoop::PublishMeshPart() {
  if (!live_ || mesh_parts_.empty()) return;
  if (next_part_ == mesh_parts_.size()) {
    if (now_ < next_repeat_) return;
    next_part_ = 0;
  }
  if (next_part_ == 0) next_repeat_ = now_ + options_.mesh_repeat;
  mesh_t& part = mesh_parts_[next_part_++];
  part.sequence = ++mesh_sequence_;
  Publish(kMeshChannel, EncodeMessage(part, &buffer_));
}

/// Each kind of failure once. What the log can no longer hold still goes out live.
void TelemetryLoop::ReportFailures() {
  if (log_.state().failure != LogFailure::kNone) {
    ReportOnce(&log_failure_reported_, EventSeverity::kError, "log.failed", log_.state().Explain());
  } else if (log_.state().moved) {
    ReportOnce(&log_move_reported_, EventSeverity::kWarning, "log.moved",
               "the session folder was moved or renamed: the session continues in its new place");
  }
  if (const std::string failure = timeline_ ? timeline_->Explain() : ""; !failure.empty()) {
    ReportOnce(&timeline_failure_reported_, EventSeverity::kWarning, "timeline.failed", failure);
  }
  if (live_errors_ > 0) {
    ReportOnce(
        &live_failure_reported_, EventSeverity::kWarning, "live.failed",
        "the network refused messages of --live; the log has them all and summary.json counts "
        "them; check the interface and its multicast route");
  }
}

void TelemetryLoop::ReportOnce(bool* reported, EventSeverity severity, const char* name,
                               const std::string& text) {
  if (*reported) return;
  *reported = true;
  AddEvent(severity, name, text);
  if (options_.tell) options_.tell(text);
}

template <typename Message>
void TelemetryLoop::Send(const char* channel, Nanoseconds time, const Message& message,
                         bool publish) {
  const std::span<const std::uint8_t> bytes = EncodeMessage(message, &buffer_);
  log_.Write(channel, time, bytes);
  if (publish) Publish(channel, bytes);
}

void TelemetryLoop::Publish(const char* channel, std::span<const std::uint8_t> bytes) {
  if (!live_) return;
  const int status = live_->publish(channel, bytes.data(), static_cast<unsigned int>(bytes.size()));
  ++(status == 0 ? live_messages_ : live_errors_);
}

}  // namespace hpdm
