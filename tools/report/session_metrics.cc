#include "tools/report/session_metrics.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <span>

#include "engine/error.h"
#include "lcmtypes/codec.h"
#include "lcmtypes/log.h"
#include "lcmtypes/logged_session.h"
#include "tools/report_text.h"

namespace hpdm {
namespace {

constexpr std::string_view kStartPrefix = "instruments: ";
/// Wall times are later than this, microseconds since 1970; the lockstep clock begins at 0.
constexpr std::int64_t kFirstWallTime = 1'000'000'000'000;
/// A tick takes more bytes of a log than this: how many ticks a file can tell of.
constexpr std::uint64_t kFewestTickBytes = 50;
/// No haptic loop is slower, s a period.
constexpr double kLongestPeriod = 0.05;

/// Sequence numbers of one channel, which rise by one.
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

/// All of a log but its ticks, as it passes by.
class Surroundings {
 public:
  void Visit(const LogEvent& event) {
    ++events_;
    if (event.channel == kContactChannel) Read(event, &contact_);
    if (event.channel == kOrganChannel) Read(event, &organ_);
    if (event.channel == kMeshChannel && Read(event, &mesh_) && mesh_.organ >= 0 &&
        mesh_.organ < kMaxOrgans) {
      meshes_[mesh_.organ].push_back(mesh_);
    }
    if (event.channel == kStatsChannel && Read(event, &stats_)) {
      NoteEpoch(event.time_us, stats_.time_ns);
      AddStats();
    }
    if (event.channel == kEventChannel && Read(event, &event_)) {
      NoteEpoch(event.time_us, event_.time_ns);
      AddEvent();
    }
  }

  void Fill(SessionReading* reading) {
    SessionReport& report = reading->report;
    report.health.events = events_;
    report.health.unreadable += unreadable_;
    report.health.closed = closed_;
    for (const auto& [channel, sequence] : sequences_) report.health.lost += sequence.lost();
    report.start_us = epoch_us_ > kFirstWallTime ? epoch_us_ : 0;
    report.stolen = stolen_;
    report.events = std::move(session_events_);
    for (std::size_t k = 0; k < kLatencyCount; ++k) report.latencies[k] = Latency(k);
    for (const auto& [organ, parts] : meshes_) {
      const auto index = static_cast<std::size_t>(organ);
      if (report.organs.size() <= index) report.organs.resize(index + 1);
      report.organs[index] = parts.front().name;
      OrganDescription description;
      std::string why;
      if (JoinMesh(parts, &description, &why)) reading->course.organs.push_back(description);
    }
    NameHands(&report);
  }

 private:
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

  void AddStats() {
    for (const bin_t& bin : stats_.bins) {
      const int which = bin.distribution;
      if (which < 0 || which >= static_cast<int>(kLatencyCount) || bin.count <= 0) continue;
      bins_[static_cast<std::size_t>(which)][bin.upper_ns] += static_cast<std::uint64_t>(bin.count);
    }
    for (std::size_t k = 0; k < kLatencyCount; ++k) {
      max_[k] = std::max<Nanoseconds>(max_[k], stats_.latencies[k].max_ns);
    }
    stolen_ += ToSeconds(stats_.stolen_ns);
  }

  void AddEvent() {
    if (event_.name == "session.start") start_text_ = event_.text;
    closed_ |= event_.name == "session.end";
    const auto severity = static_cast<EventSeverity>(
        std::clamp<int>(event_.severity, 0, static_cast<int>(EventSeverity::kError)));
    session_events_.push_back({ToSeconds(event_.time_ns), severity, event_.name, event_.text});
  }

  LatencyReport Latency(std::size_t k) const {
    LatencyReport report;
    report.name = kLatencyNames[k];
    report.max = max_[k];
    report.bins.assign(bins_[k].begin(), bins_[k].end());
    for (const auto& [upper, count] : report.bins) report.count += count;
    // As Histogram::Percentile.
    const auto percentile = [&](double fraction) {
      const double wanted = fraction * static_cast<double>(report.count) * (1 - 1e-12);
      double seen = 0;
      for (const auto& [upper, count] : report.bins) {
        seen += static_cast<double>(count);
        if (seen >= wanted) return std::min(upper, report.max);
      }
      return report.count == 0 ? 0 : report.max;
    };
    report.p50 = percentile(0.5);
    report.p90 = percentile(0.9);
    report.p99 = percentile(0.99);
    report.p99_9 = percentile(0.999);
    return report;
  }

  /// From the session's first event, as far as its names can be told apart.
  void NameHands(SessionReport* report) const {
    std::vector<std::string> names;
    if (start_text_.starts_with(kStartPrefix)) {
      std::string rest = start_text_.substr(kStartPrefix.size());
      if (report->hands.size() == 1) {
        names.push_back(rest);
      } else {
        for (std::size_t at = 0; at != std::string::npos;) {
          const std::size_t comma = rest.find(", ", at);
          names.push_back(rest.substr(at, comma - at));
          at = comma == std::string::npos ? comma : comma + 2;
        }
      }
    }
    for (std::size_t h = 0; h < report->hands.size(); ++h) {
      report->hands[h].name =
          names.size() == report->hands.size() ? names[h] : "hand " + std::to_string(h + 1);
    }
  }

  // Reused, so that a long log allocates little.
  contact_t contact_{};
  organ_t organ_{};
  mesh_t mesh_{};
  stats_t stats_{};
  event_t event_{};
  std::uint64_t events_ = 0, unreadable_ = 0;
  std::map<std::string, Sequence> sequences_;
  std::map<std::int32_t, std::vector<mesh_t>> meshes_;
  bool epoch_known_ = false, closed_ = false;
  std::int64_t epoch_us_ = 0;
  std::string start_text_;
  double stolen_ = 0;
  std::array<std::map<Nanoseconds, std::uint64_t>, kLatencyCount> bins_;
  std::array<Nanoseconds, kLatencyCount> max_{};
  std::vector<SessionEvent> session_events_;
};

/// Sums over the ticks of one instrument, of all of them or of those with one organ.
class ContactSums {
 public:
  explicit ContactSums(double limit) : limit_(limit) {}

  /// A tick and how long it stands, s. `counts`: its force and depth are of these contacts.
  void Add(double time, double duration, const ToolSample& tool, bool counts, bool touches) {
    const double force = counts ? tool.force_W.norm() : 0;
    const bool over = force > limit_;
    metrics_.peak_force = std::max(metrics_.peak_force, force);
    metrics_.impulse += force * duration;
    if (over) metrics_.over_limit += duration;
    if (over && !over_) ++metrics_.over_limit_count;
    over_ = over;
    if (counts) metrics_.deepest_press = std::max(metrics_.deepest_press, tool.depth);
    if (!touches) return;
    if (time - end_ > kContactPause) ++metrics_.count;
    end_ = time + duration;
    metrics_.time += duration;
    contact_impulse_ += force * duration;
  }
  ContactMetrics Metrics() const {
    ContactMetrics metrics = metrics_;
    if (metrics.time > 0) metrics.mean_force = contact_impulse_ / metrics.time;
    return metrics;
  }

 private:
  double limit_;
  ContactMetrics metrics_;
  double contact_impulse_ = 0;
  double end_ = -std::numeric_limits<double>::infinity();  // of the last contact
  bool over_ = false;
};

bool IsUsable(const HapticSample& sample) {
  for (int t = 0; t < sample.tool_count; ++t) {
    const ToolSample& tool = sample.tools[static_cast<std::size_t>(t)];
    if (!tool.joints.allFinite() || !tool.p_tip_W.allFinite() || !tool.force_W.allFinite() ||
        !std::isfinite(tool.depth)) {
      return false;
    }
  }
  return true;
}

CourseVector CourseOf(const ToolSample& tool) {
  CourseVector course;
  course << tool.p_tip_W, tool.joints.head<4>(), tool.force_W;
  return course;
}

/// The ticks of a log, each of which stands until the next.
class Ticks {
 public:
  explicit Ticks(double force_limit, std::uint64_t most) : limit_(force_limit), most_(most) {}

  /// False: the tick is not one that can follow.
  bool Add(const LoggedTick& logged) {
    HapticSample sample = logged.sample;
    if (!IsUsable(sample) || (begun_ && !Follows(sample))) return false;
    if (begun_) {
      KnowPeriod(sample, logged.lost_before);
      const double until = logged.lost_before > 0 ? Time(last_) + period_ : Time(sample);
      Close(std::min(until, Time(sample)));
      missing_ += std::max(0.0, Time(sample) - until);
    } else {
      first_ = sample.tick;
      start_ = Time(sample);
      hands_.assign(static_cast<std::size_t>(sample.tool_count), Hand(limit_));
    }
    if (!logged.has_output && begun_) HoldOutput(&sample);
    begun_ = true;
    ++ticks_;
    skipped_.late_wake_up += sample.skipped.late_wake_up;
    skipped_.long_compute += sample.skipped.long_compute;
    skipped_.stalled += sample.skipped.stalled;
    measured_ |= sample.wake_late_ns != 0 || sample.compute_ns != 0;
    for (std::size_t h = 0; h < hands_.size(); ++h) {
      if (sample.paused) {
        hands_[h].course.Break();
      } else {
        hands_[h].course.Add(Time(sample), CourseOf(sample.tools[h]));
      }
    }
    last_ = sample;
    return true;
  }

  void Fill(SessionReading* reading) {
    if (!begun_) return;
    Close(Time(last_) + period_);
    SessionReport& report = reading->report;
    report.ticks = ticks_;
    report.skipped = skipped_;
    report.measured = measured_;
    report.duration = Time(last_) + period_ - start_;
    report.paused = paused_;
    report.active = report.duration - paused_ - missing_;
    reading->course.pauses = std::move(pauses_);
    for (Hand& hand : hands_) {
      hand.course.Break();
      HandReport figures;
      figures.motion = MeasureMotion(hand.course.stretches());
      figures.contact = hand.all.Metrics();
      for (const ContactSums& organ : hand.organs) figures.by_organ.push_back(organ.Metrics());
      figures.device_lost = hand.device_lost;
      report.hands.push_back(std::move(figures));
      reading->course.hands.push_back({hand.course.stretches(), std::move(hand.peaks)});
    }
    if (hands_.size() == 2) {
      report.both_moving = BothMoving(hands_[0].course.stretches(), hands_[1].course.stretches());
    }
  }

 private:
  struct Hand {
    explicit Hand(double limit) : all(limit) {}
    UniformCourse course;
    ContactSums all;
    std::vector<ContactSums> organs;
    std::vector<SessionCourse::Peaks> peaks;
    double device_lost = 0;
  };

  static double Time(const HapticSample& sample) { return ToSeconds(sample.time_ns); }

  bool Follows(const HapticSample& sample) const {
    if (sample.tool_count != static_cast<int>(hands_.size()) || sample.tick <= last_.tick ||
        sample.tick - first_ > most_) {
      return false;
    }
    const double passed = Time(sample) - Time(last_);
    return passed > 0 && passed <= kLongestPeriod * static_cast<double>(sample.tick - last_.tick);
  }

  void KnowPeriod(const HapticSample& sample, std::uint64_t lost) {
    if (lost == 0) {
      period_ = (Time(sample) - Time(last_)) / static_cast<double>(sample.tick - last_.tick);
    }
  }

  /// What the tick's missing output was is not known: the one before stands.
  void HoldOutput(HapticSample* sample) const {
    for (std::size_t h = 0; h < hands_.size(); ++h) {
      const ToolSample& before = last_.tools[h];
      ToolSample& tool = sample->tools[h];
      tool.force_W = before.force_W;
      tool.depth = before.depth;
      tool.organ = before.organ;
      tool.kind = before.kind;
    }
  }

  /// The last tick stands until then, s.
  void Close(double until) {
    const double time = Time(last_), duration = until - time;
    if (last_.paused) {
      paused_ += duration;
      if (pauses_.empty() || time - pauses_.back().second > period_ / 2) {
        pauses_.emplace_back(time, until);
      }
      pauses_.back().second = until;
    }
    for (std::size_t h = 0; h < hands_.size(); ++h) {
      Hand& hand = hands_[h];
      const ToolSample& tool = last_.tools[h];
      AddPeaks(tool, time, &hand.peaks);
      if (last_.paused) continue;
      if (!tool.device_valid) hand.device_lost += duration;
      const bool touches = tool.kind != ContactKind::kNone;
      hand.all.Add(time, duration, tool, true, touches);
      const auto organ = static_cast<std::size_t>(tool.organ);
      const bool at_organ = touches && tool.organ >= 0 && tool.organ < kMaxOrgans;
      if (at_organ && hand.organs.size() <= organ) {
        hand.organs.resize(organ + 1, ContactSums(limit_));
      }
      for (std::size_t o = 0; o < hand.organs.size(); ++o) {
        const bool here = at_organ && o == organ;
        hand.organs[o].Add(time, duration, tool, here, here);
      }
    }
  }

  void AddPeaks(const ToolSample& tool, double time, std::vector<SessionCourse::Peaks>* peaks) {
    const auto at = static_cast<std::size_t>((time - start_) / kCoursePeriod);
    if (peaks->size() <= at) peaks->resize(at + 1);
    SessionCourse::Peaks& peak = (*peaks)[at];
    peak.force = std::max(peak.force, static_cast<float>(tool.force_W.norm()));
    peak.depth = std::max(peak.depth, static_cast<float>(tool.depth));
    if (tool.kind != ContactKind::kNone && tool.organ >= 0 && tool.organ < kMaxOrgans) {
      peak.organ = static_cast<std::int8_t>(tool.organ);
    }
  }

  double limit_;
  std::uint64_t most_;
  bool begun_ = false;
  std::uint64_t first_ = 0, ticks_ = 0;
  double start_ = 0, period_ = 0.001, paused_ = 0, missing_ = 0;
  bool measured_ = false;
  SkippedTicks skipped_;
  HapticSample last_;
  std::vector<Hand> hands_;
  std::vector<std::pair<double, double>> pauses_;
};

}  // namespace

std::vector<std::string> LogReport::Faults() const {
  std::vector<std::string> faults;
  const auto add = [&faults](std::uint64_t count, const char* what) {
    if (count > 0) faults.push_back(WithCommas(static_cast<long long>(count)) + what);
  };
  if (!closed) faults.emplace_back("the session was not closed: its end is missing");
  add(damaged_bytes, " bytes in the log are damaged");
  add(torn_bytes, " bytes at the log's end are torn off an event");
  add(unreadable, " messages hold nothing usable");
  add(ticks_lost, " haptic ticks ran but are not in the log");
  add(outputs_lost, " haptic ticks lack their output; the one before stands for it");
  add(lost, " other messages are missing by their sequence numbers");
  return faults;
}

SessionReading ReadSession(const std::string& log, double force_limit) {
  Surroundings surroundings;
  TickReader reader(log, [&surroundings](const LogEvent& event) { surroundings.Visit(event); });
  Ticks ticks(force_limit, reader.log().size() / kFewestTickBytes);
  SessionReading reading;
  SessionReport& report = reading.report;
  report.log = log;
  report.force_limit = force_limit;
  LoggedTick tick;
  bool any = false;
  while (reader.Next(&tick)) {
    if (!ticks.Add(tick)) {
      ++report.health.unreadable;
      continue;
    }
    any = true;
    report.health.ticks_lost += tick.lost_before;
    report.health.outputs_lost += tick.has_output ? 0 : 1;
  }
  if (!any) {
    throw InputError(log + ": holds no haptic tick: give the session.lcmlog of a session");
  }
  report.health.unreadable += reader.unreadable();
  report.health.bytes = reader.log().size();
  report.health.torn_bytes = reader.log().size() - reader.log().intact_end();
  report.health.damaged_bytes = reader.log().damaged_bytes() - report.health.torn_bytes;
  ticks.Fill(&reading);
  surroundings.Fill(&reading);
  for (HandReport& hand : report.hands) {
    if (report.organs.size() < hand.by_organ.size()) report.organs.resize(hand.by_organ.size());
  }
  for (std::size_t o = 0; o < report.organs.size(); ++o) {
    if (report.organs[o].empty()) report.organs[o] = "organ " + std::to_string(o + 1);
  }
  for (HandReport& hand : report.hands) hand.by_organ.resize(report.organs.size());
  return reading;
}

}  // namespace hpdm
