#include "tools/report/session_ticks.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "tools/report/motion_metrics.h"

namespace hpdm {
namespace {

/// What no session reaches, m and N: a damaged message does.
constexpr double kFarthest = 1e3, kStrongest = 1e6;
/// No haptic loop is slower, s a period.
constexpr double kLongestPeriod = 0.05;

bool IsUsable(const HapticSample& sample) {
  for (int t = 0; t < sample.tool_count; ++t) {
    const ToolSample& tool = sample.tools[static_cast<std::size_t>(t)];
    if (!(tool.joints.cwiseAbs().maxCoeff() < kFarthest) || !tool.joints.allFinite() ||
        !tool.p_tip_W.allFinite() || tool.p_tip_W.norm() > kFarthest || !tool.force_W.allFinite() ||
        tool.force_W.norm() > kStrongest || !(std::abs(tool.depth) < kFarthest)) {
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

}  // namespace

void ContactSums::Add(double time, double duration, const ToolSample& tool, bool counts,
                      bool touches) {
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

ContactMetrics ContactSums::Metrics() const {
  ContactMetrics metrics = metrics_;
  if (metrics.time > 0) metrics.mean_force = contact_impulse_ / metrics.time;
  return metrics;
}

bool SessionTicks::Add(const LoggedTick& logged) {
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
  reading->course.start = start_;
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

bool SessionTicks::Follows(const HapticSample& sample) const {
  if (sample.tool_count != static_cast<int>(hands_.size()) || sample.tick <= last_.tick ||
      sample.tick - first_ > most_) {
    return false;
  }
  const double passed = Time(sample) - Time(last_);
  return passed > 0 && passed <= kLongestPeriod * static_cast<double>(sample.tick - last_.tick);
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
    tool.force_W = before.force_W;
    tool.depth = before.depth;
    tool.organ = before.organ;
    tool.kind = before.kind;
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

void SessionTicks::AddPeaks(const ToolSample& tool, double time, double until,
                            std::vector<SessionCourse::Peaks>* peaks) const {
  const auto bin = [this](double at) {
    return static_cast<std::size_t>((at - start_) / kCoursePeriod);
  };
  // To the middle of its last period: the next tick's bin is that one's own.
  const std::size_t last = bin(std::max(time, until - period_ / 2));
  if (peaks->size() <= last) peaks->resize(last + 1);
  for (std::size_t b = bin(time); b <= last; ++b) {
    SessionCourse::Peaks& peak = (*peaks)[b];
    peak.force = std::max(peak.force, static_cast<float>(tool.force_W.norm()));
    peak.depth = std::max(peak.depth, static_cast<float>(tool.depth));
    if (tool.kind != ContactKind::kNone && tool.organ >= 0 && tool.organ < kMaxOrgans) {
      peak.organ = static_cast<std::int8_t>(tool.organ);
    }
  }
}

}  // namespace hpdm
