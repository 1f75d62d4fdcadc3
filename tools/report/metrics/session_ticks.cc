#include "tools/report/metrics/session_ticks.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "lcmtypes/analysis/tissue_force.h"
#include "tools/report/metrics/motion_metrics.h"

namespace hpdm {
namespace {

/// Values beyond these, m and N, occur only in damaged messages.
constexpr double kMaxCoordinate = 1e3, kMaxForce = 1e6;
/// Longest period of a haptic loop, s.
constexpr double kMaxTickPeriod = 0.05;

bool IsUsable(const HapticSample& sample) {
  for (int t = 0; t < sample.tool_count; ++t) {
    const ToolSample& tool = sample.tools[static_cast<std::size_t>(t)];
    if (!(tool.joints.cwiseAbs().maxCoeff() < kMaxCoordinate) || !tool.joints.allFinite() ||
        !tool.p_tip_W.allFinite() || tool.p_tip_W.norm() > kMaxCoordinate ||
        !tool.force_W.allFinite() || tool.force_W.norm() > kMaxForce ||
        !(std::abs(tool.depth) < kMaxCoordinate)) {
      return false;
    }
  }
  return true;
}

MotionVector MotionOf(const ToolSample& tool) {
  MotionVector series;
  series << tool.p_tip_W, tool.joints.head<4>(), TissueForce(tool);
  return series;
}

/// Returns the intervals in which the jaws hold tissue, in order.
std::vector<MotionInterval> HoldingIntervals(const std::vector<SessionTimeSeries::Peaks>& peaks,
                                             double start) {
  std::vector<MotionInterval> holding;
  bool holds = false;
  for (std::size_t i = 0; i < peaks.size(); ++i) {
    const double from = start + static_cast<double>(i) * kMotionPeriod;
    const bool held = std::exchange(holds, peaks[i].holds);
    if (holds && !held) holding.emplace_back(from, from);
    if (holds) holding.back().second = from + kMotionPeriod;
  }
  return holding;
}

}  // namespace

void ContactSums::Add(double time, double duration, const ToolSample& tool, bool counts,
                      bool touches) {
  const double force = counts ? TissueForce(tool).norm() : 0;
  const bool over = force > limits_.force;
  metrics_.peak_force = std::max(metrics_.peak_force, force);
  metrics_.impulse += force * duration;
  if (over) metrics_.over_limit += duration;
  if (over && !over_force_) ++metrics_.over_limit_count;
  over_force_ = over;
  const double depth = counts ? tool.depth : 0;
  const bool too_deep = depth > limits_.depth;
  metrics_.deepest_press = std::max(metrics_.deepest_press, depth);
  if (too_deep) metrics_.over_depth += duration;
  if (too_deep && !over_depth_) ++metrics_.over_depth_count;
  over_depth_ = too_deep;
  metrics_.slips += slips_.Add(time, counts ? tool.slip : 0);
  if (!touches) return;
  const bool shown = (tool.guard_flags & kGuardDisabled) == 0;
  if (!shown) metrics_.forces_off += duration;
  if (shown && (tool.guard_flags & kGuardClamped) != 0) metrics_.clamped += duration;
  if (time - end_ > kContactPause) ++metrics_.count;
  end_ = time + duration;
  metrics_.time += duration;
  if (shown) contact_impulse_ += force * duration;
}

ContactMetrics ContactSums::Metrics() const {
  ContactMetrics metrics = metrics_;
  const double shown = metrics.time - metrics.forces_off;
  if (shown > 0) metrics.mean_force = contact_impulse_ / shown;
  return metrics;
}

bool SessionTicks::Add(const LoggedTick& logged) {
  HapticSample sample = logged.sample;
  if (!IsUsable(sample)) return false;
  if (begun_ && !Follows(sample)) {
    if (ticks_ > 1) return false;
    begun_ = false;  // if the first two ticks contradict each other, the second is used
  }
  if (begun_) {
    KnowPeriod(sample, logged.lost_before);
    const double until = logged.lost_before > 0 ? Time(last_) + period_ : Time(sample);
    Close(std::min(until, Time(sample)));
    const double missing = std::max(0.0, Time(sample) - until);
    missing_ += missing;
    for (Hand& hand : hands_) hand.SkipTime(missing);
  } else {
    Begin(sample);
  }
  if (!logged.has_output && begun_) {
    HoldOutput(&sample);
  } else {
    for (std::size_t h = 0; h < hands_.size(); ++h) {
      ToolSample& tool = sample.tools[h];
      if (!hands_[h].depth.Add(Time(sample), tool)) tool.depth = 0;
    }
  }
  begun_ = true;
  ++ticks_;
  NoteExchanges(sample);
  skipped_.late_wake_up += sample.skipped.late_wake_up;
  skipped_.long_compute += sample.skipped.long_compute;
  skipped_.stalled += sample.skipped.stalled;
  measured_ |= sample.wake_late_ns != 0 || sample.compute_ns != 0;
  for (std::size_t h = 0; h < hands_.size(); ++h) {
    if (sample.paused || !sample.tools[h].device_valid) {
      hands_[h].series.Break();  // the repeated last pose is neither movement nor rest
    } else {
      hands_[h].series.Add(Time(sample), MotionOf(sample.tools[h]));
    }
  }
  last_ = sample;
  return true;
}

void SessionTicks::Fill(SessionReading* reading) {
  if (!begun_) return;
  Close(Time(last_) + period_);
  SessionReport& report = reading->report;
  report.ticks = ticks_;
  report.skipped = skipped_;
  report.measured = measured_;
  report.duration = Time(last_) + period_ - start_;
  report.paused = paused_;
  report.active = report.duration - paused_ - missing_;
  reading->series.start = start_;
  reading->series.pauses = std::move(pauses_);
  for (Hand& hand : hands_) {
    hand.series.Break();
    HandReport results;
    results.motion = MeasureMotion(hand.series.segments());
    results.contact = hand.all.Metrics();
    for (const ContactSums& organ : hand.organs) results.by_organ.push_back(organ.Metrics());
    results.device_lost = hand.device_lost;
    results.depth_unknown = hand.depth_unknown;
    results.held = std::move(hand.held);
    report.hands.push_back(std::move(results));
    reading->series.hands.push_back({hand.series.segments(), std::move(hand.peaks)});
  }
  report.exchanges = exchanges_;
  if (hands_.size() >= 2) {
    std::vector<HandWork> work;
    for (const SessionTimeSeries::Hand& hand : reading->series.hands) {
      work.push_back({MovingIntervals(hand.segments), HoldingIntervals(hand.peaks, start_)});
    }
    report.work = MeasureWork(work);
  }
  if (hands_.size() == 2) {
    report.both_moving = BothMoving(hands_[0].series.segments(), hands_[1].series.segments());
  }
}

void SessionTicks::Begin(const HapticSample& sample) {
  start_ = Time(sample);
  ticks_ = 0;
  exchanges_ = 0;
  skipped_ = {};
  measured_ = false;
  hands_.assign(static_cast<std::size_t>(sample.tool_count), Hand(limits_));
}

void SessionTicks::NoteExchanges(const HapticSample& sample) {
  for (std::size_t h = 0; h < hands_.size(); ++h) {
    Hand& hand = hands_[h];
    const int instrument_index = sample.tools[h].instrument_index;
    if (instrument_index == hand.instrument_index) continue;
    hand.instrument_index = instrument_index;
    ++exchanges_;
    // An exchange in the first tick: the hand never held its first instrument.
    if (ticks_ == 1) hand.held.clear();
    const bool known = std::any_of(hand.held.begin(), hand.held.end(),
                                   [instrument_index](const UsedInstrument& held) {
                                     return held.instrument_index == instrument_index;
                                   });
    if (!known) hand.held.push_back({instrument_index, ""});
  }
}

bool SessionTicks::Follows(const HapticSample& sample) const {
  if (sample.tool_count != static_cast<int>(hands_.size()) || sample.tick <= last_.tick) {
    return false;
  }
  const double passed = Time(sample) - Time(last_);
  return passed > 0 && passed <= kMaxTickPeriod * static_cast<double>(sample.tick - last_.tick);
}

void SessionTicks::KnowPeriod(const HapticSample& sample, std::uint64_t lost) {
  if (lost == 0) {
    period_ = (Time(sample) - Time(last_)) / static_cast<double>(sample.tick - last_.tick);
  }
}

void SessionTicks::HoldOutput(HapticSample* sample) const {
  for (std::size_t h = 0; h < hands_.size(); ++h) {
    const ToolSample& before = last_.tools[h];
    ToolSample& tool = sample->tools[h];
    tool.reaction_W = before.reaction_W;
    tool.force_W = before.force_W;
    tool.depth = before.depth;
    tool.organ = before.organ;
    tool.kind = before.kind;
    tool.guard_flags = before.guard_flags;
  }
}

void SessionTicks::Close(double until) {
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
    AddPeaks(tool, time, until, &hand.peaks);
    if (last_.paused) {
      hand.SkipTime(duration);
      continue;
    }
    if (!tool.device_valid) hand.device_lost += duration;
    const bool touches = tool.kind != ContactKind::kNone;
    if (touches && !hand.depth.counts()) hand.depth_unknown += duration;
    hand.all.Add(time, duration, tool, true, touches);
    const auto organ = static_cast<std::size_t>(tool.organ);
    const bool at_organ = touches && tool.organ >= 0 && tool.organ < kMaxOrgans;
    if (at_organ && hand.organs.size() <= organ) {
      hand.organs.resize(organ + 1, ContactSums(limits_));
    }
    for (std::size_t o = 0; o < hand.organs.size(); ++o) {
      const bool here = at_organ && o == organ;
      hand.organs[o].Add(time, duration, tool, here, here);
    }
  }
}

void SessionTicks::AddPeaks(const ToolSample& tool, double time, double until,
                            std::vector<SessionTimeSeries::Peaks>* peaks) const {
  const auto bin = [this](double at) {
    return static_cast<std::size_t>((at - start_) / kMotionPeriod);
  };
  // Ends at the middle of the last period, so that the next tick's bin stays that tick's own.
  const std::size_t end = std::min(bin(std::max(time, until - period_ / 2)) + 1, most_peaks_);
  if (peaks->size() < end) peaks->resize(end);
  for (std::size_t b = bin(time); b < end; ++b) {
    SessionTimeSeries::Peaks& peak = (*peaks)[b];
    peak.force = std::max(peak.force, static_cast<float>(TissueForce(tool).norm()));
    peak.depth = std::max(peak.depth, static_cast<float>(tool.depth));
    peak.holds |= tool.kind == ContactKind::kGrasp && !last_.paused;
    if (tool.kind != ContactKind::kNone && tool.organ >= 0 && tool.organ < kMaxOrgans) {
      peak.organ = static_cast<std::int8_t>(tool.organ);
    }
  }
}

}  // namespace hpdm
