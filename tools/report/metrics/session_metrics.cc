#include "tools/report/metrics/session_metrics.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <span>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/text_list.h"
#include "lcmtypes/analysis/logged_session.h"
#include "lcmtypes/log/log.h"
#include "lcmtypes/telemetry/exercise_events.h"
#include "lcmtypes/telemetry/session_info.h"
#include "lcmtypes/wire/codec.h"
#include "tools/report/metrics/session_ticks.h"
#include "tools/shared/latency_sums.h"
#include "tools/shared/mesh_parts.h"
#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

/// Earliest wall time, microseconds since 1970. Smaller times are of the lockstep clock, which
/// begins at 0.
constexpr std::int64_t kFirstWallTime = 1'000'000'000'000;
/// Bounds the peaks of a time series: one for each tick that fits the file, at this many bytes per
/// tick, and an hour without ticks.
constexpr std::uint64_t kMinTickBytes = 50;
constexpr std::size_t kSilentPeaks = 720'000;
/// Longest names and texts from a log, bytes. A damaged or hostile log may have longer ones.
constexpr std::size_t kMaxNameLength = 256, kMaxTextLength = 1000;

/// Counts the messages missing from a channel, whose sequence numbers rise by one.
class Sequence {
 public:
  void Add(std::int64_t number) {
    if (has_last_ && number > last_) {
      lost_ += static_cast<std::uint64_t>(number) - static_cast<std::uint64_t>(last_) - 1;
    }
    if (!has_last_ || number > last_) last_ = number;
    has_last_ = true;
  }
  std::uint64_t lost() const { return lost_; }

 private:
  bool has_last_ = false;
  std::int64_t last_ = 0;
  std::uint64_t lost_ = 0;
};

/// Collects everything but the ticks while a log is read.
class LogSummary {
 public:
  explicit LogSummary(const std::optional<ExerciseOptions>& exercise) {
    if (exercise) exercise_.emplace(*exercise);
  }

  void Visit(const LogEvent& event) {
    ++events_;
    if (event.channel == kContactChannel && Read(event, &contact_)) AddStep();
    if (event.channel == kOrganChannel) Read(event, &organ_);
    if (event.channel == kMeshChannel && Read(event, &mesh_) && mesh_.organ >= 0 &&
        mesh_.organ < kMaxOrgans) {
      Organ& organ = organs_[mesh_.organ];
      organ.name = mesh_.name.substr(0, kMaxNameLength);
      organ.mesh.Take(std::move(mesh_));
    }
    if (event.channel == kStatsChannel && Read(event, &stats_)) {
      NoteEpoch(event.time_us, stats_.time_ns);
      latencies_.Add(stats_);
      stolen_ += ToSeconds(stats_.stolen_ns);
      steps_shed_ += stats_.steps_shed;
    }
    if (event.channel == kEventChannel && Read(event, &event_)) {
      NoteEpoch(event.time_us, event_.time_ns);
      AddEvent();
    }
  }

  void Fill(const std::vector<std::vector<std::string>>& instruments, SessionReading* reading) {
    SessionReport& report = reading->report;
    report.health.events = events_;
    report.health.unreadable += unreadable_;
    report.health.closed = closed_;
    for (const auto& [channel, sequence] : sequences_) report.health.lost += sequence.lost();
    report.start_us = epoch_us_ > kFirstWallTime ? epoch_us_ : 0;
    report.left_handed = left_handed_;
    report.stolen = stolen_;
    report.steps_shed = steps_shed_;
    report.attachments = attachments_;
    if (exercise_) report.exercise = {exercise_->options(), exercise_->result()};
    report.events = std::move(session_events_);
    for (std::size_t k = 0; k < kLatencyCount; ++k) report.latencies[k] = Latency(k);
    for (const auto& [number, organ] : organs_) {
      const auto index = static_cast<std::size_t>(number);
      if (report.organs.size() <= index) report.organs.resize(index + 1);
      report.organs[index] = organ.name;
      if (organ.mesh.whole()) {
        reading->series.organs.push_back(*organ.mesh.whole());
      } else {
        const std::string& why = organ.mesh.error();
        reading->series.organs_missing.push_back(
            organ.name + ": not drawn, " + (why.empty() ? "parts of its mesh are missing" : why));
      }
    }
    NameHands(instruments, &report);
  }

 private:
  struct Organ {
    std::string name;
    MeshParts mesh;
  };

  template <typename Message>
  bool Read(const LogEvent& event, Message* message) {
    if (!DecodeMessage(event.data, message)) {
      ++unreadable_;
      return false;
    }
    sequences_[event.channel].Add(message->sequence);
    return true;
  }

  void NoteEpoch(std::int64_t time_us, std::int64_t time_ns) {
    if (epoch_known_) return;
    epoch_known_ = true;
    epoch_us_ = time_us - time_ns / 1000;
  }

  void AddStep() {
    StepSample sample;
    std::int64_t visible_tick = kNeverVisible;
    if (!FromMessage(contact_, &sample, &visible_tick)) return;
    if (exercise_) exercise_->Add(sample);
    attachments_.resize(std::max(attachments_.size(), ToSize(sample.attachment_count)));
    for (int a = 0; a < sample.attachment_count; ++a) {
      const AttachmentOutcome& now = sample.attachments[a];
      AttachmentReport& report = attachments_[ToSize(a)];
      report.name = "attachment " + std::to_string(a + 1);
      report.peak_load = std::max(report.peak_load, now.load_W.norm());
      report.largest_damage = now.largest_damage;
      report.freed_area = now.freed_area;
      report.burnt_area = now.burnt_area;
      report.cut_area = now.cut_area;
      report.dissipated = now.dissipated;
    }
  }

  void AddEvent() {
    if (event_.name == kSessionStart) start_text_ = event_.text;
    if (exercise_) AddExerciseEvent(event_.time_ns, event_.name, event_.text, &*exercise_);
    left_handed_ |= event_.name == kLeftHanded;
    closed_ |= event_.name == "session.end";
    const auto severity = static_cast<EventSeverity>(
        std::clamp<int>(event_.severity, 0, static_cast<int>(EventSeverity::kError)));
    session_events_.push_back({ToSeconds(event_.time_ns), severity,
                               event_.name.substr(0, kMaxNameLength),
                               event_.text.substr(0, kMaxTextLength)});
  }

  LatencyReport Latency(std::size_t k) const {
    const LatencySums::Sum& sum = latencies_.Of(k);
    LatencyReport report;
    report.name = kLatencyNames[k];
    report.count = sum.count;
    report.max = sum.max_ns;
    report.bins.assign(sum.bins.begin(), sum.bins.end());
    report.p50 = sum.Percentile(0.5);
    report.p90 = sum.Percentile(0.9);
    report.p99 = sum.Percentile(0.99);
    report.p99_9 = sum.Percentile(0.999);
    return report;
  }

  /// True if the session began with these instruments, as far as the log says.
  bool BeganWith(const std::vector<std::vector<std::string>>& instruments) const {
    std::vector<std::string> names;
    for (const std::vector<std::string>& hand : instruments) names.push_back(hand.front());
    return start_text_.empty() || start_text_ == SessionStartText(names);
  }

  /// Names the hands and all that they held by the scene. Without the session's scene only the
  /// names of the start event are known.
  void NameHands(const std::vector<std::vector<std::string>>& instruments,
                 SessionReport* report) const {
    std::vector<HandReport>& hands = report->hands;
    const bool scene_known = instruments.size() == hands.size() && BeganWith(instruments);
    const std::vector<std::string> started = InstrumentsIn(start_text_, hands.size());
    for (std::size_t h = 0; h < hands.size(); ++h) {
      std::vector<std::string> names = {"hand " + std::to_string(h + 1)};
      if (scene_known) {
        names = instruments[h];
      } else if (started.size() == hands.size()) {
        names = {started[h]};
      }
      hands[h].name = names[0].substr(0, kMaxNameLength);
      for (UsedInstrument& held : hands[h].held) {
        const auto at = static_cast<std::size_t>(held.instrument_index);
        held.name = at < names.size() ? names[at].substr(0, kMaxNameLength)
                                      : "exchange " + std::to_string(at);
      }
    }
  }

  // Reused, so that a long log causes few allocations.
  contact_t contact_{};
  organ_t organ_{};
  mesh_t mesh_{};
  stats_t stats_{};
  event_t event_{};
  std::uint64_t events_ = 0, unreadable_ = 0;
  std::map<std::string, Sequence> sequences_;
  std::map<std::int32_t, Organ> organs_;
  std::vector<AttachmentReport> attachments_;
  std::optional<ExerciseEvaluator> exercise_;
  bool epoch_known_ = false, closed_ = false, left_handed_ = false;
  std::int64_t epoch_us_ = 0;
  std::string start_text_;
  double stolen_ = 0;
  std::int64_t steps_shed_ = 0;
  LatencySums latencies_;
  std::vector<SessionEvent> session_events_;
};

// Moves the zero of all times from the session's clock, which begins before the scene is ready, to the
// first tick.
void CountFromFirstTick(SessionReading* reading) {
  const double zero = std::exchange(reading->series.start, 0);
  SessionReport& report = reading->report;
  if (report.start_us > 0) report.start_us += std::llround(1e6 * zero);
  for (SessionEvent& event : report.events) event.time -= zero;
  for (auto& [from, to] : reading->series.pauses) {
    from -= zero;
    to -= zero;
  }
  for (SessionTimeSeries::Hand& hand : reading->series.hands) {
    for (TimeSeriesSegment& segment : hand.segments) segment.start -= zero;
  }
}

}  // namespace

std::string HandReport::Label() const {
  std::string label;
  for (const UsedInstrument& one : held) AppendToList(one.name, &label, ", then ");
  return label;
}

const std::string& HandReport::InstrumentName(int instrument_index) const {
  const auto found = std::ranges::find(held, instrument_index, &UsedInstrument::instrument_index);
  return found == held.end() ? name : found->name;
}

std::vector<std::string> LogReport::Faults() const {
  std::vector<std::string> faults;
  const auto add = [&faults](std::uint64_t count, const char* what) {
    if (count > 0) faults.push_back(WithCommas(static_cast<long long>(count)) + what);
  };
  if (!closed) faults.emplace_back("the session was not closed: its end is missing");
  add(damaged_bytes, " bytes in the log are damaged");
  add(torn_bytes, " bytes at the log's end are an incomplete event");
  add(unreadable, " messages are unusable");
  add(ticks_lost, " haptic ticks ran but are not in the log");
  add(outputs_lost, " haptic ticks lack their output; the previous output is used");
  add(lost, " other messages are missing by their sequence numbers");
  return faults;
}

SessionReading ReadSession(const std::string& log, double force_limit,
                           const std::vector<std::vector<std::string>>& instruments,
                           double depth_limit, const std::optional<ExerciseOptions>& exercise) {
  LogSummary log_summary(exercise);
  TickReader reader(log, [&log_summary](const LogEvent& event) { log_summary.Visit(event); });
  SessionTicks ticks({force_limit, depth_limit},
                     reader.log().size() / kMinTickBytes + kSilentPeaks);
  SessionReading reading;
  SessionReport& report = reading.report;
  report.log = log;
  report.force_limit = force_limit;
  report.depth_limit = depth_limit;
  LoggedTick tick;
  bool any = false;
  while (reader.Next(&tick)) {
    if (!ticks.Add(tick)) {
      ++report.health.unreadable;
      continue;
    }
    any = true;
    report.health.ticks_lost += tick.lost_before;
    report.health.outputs_lost += tick.output_lost ? 1 : 0;
  }
  if (!any) {
    throw InputError(log + ": contains no session data; give the session.lcmlog of a session");
  }
  report.output_interval = reader.output_interval();
  report.health.unreadable += reader.unreadable();
  report.health.bytes = reader.log().size();
  report.health.torn_bytes = reader.log().size() - reader.log().intact_end();
  report.health.damaged_bytes = reader.log().damaged_bytes() - report.health.torn_bytes;
  ticks.Fill(&reading);
  log_summary.Fill(instruments, &reading);
  for (HandReport& hand : report.hands) {
    if (report.organs.size() < hand.by_organ.size()) report.organs.resize(hand.by_organ.size());
  }
  for (std::size_t o = 0; o < report.organs.size(); ++o) {
    if (report.organs[o].empty()) report.organs[o] = "organ " + std::to_string(o + 1);
  }
  for (HandReport& hand : report.hands) hand.by_organ.resize(report.organs.size());
  CountFromFirstTick(&reading);
  return reading;
}

}  // namespace hpdm
