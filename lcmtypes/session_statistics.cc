#include "lcmtypes/session_statistics.h"

#include <algorithm>

namespace hpdm {
namespace {

distribution_t ToMessage(const Histogram& histogram) {
  distribution_t message;
  message.count = static_cast<std::int64_t>(histogram.count());
  message.p50_ns = histogram.Percentile(0.5);
  message.p99_ns = histogram.Percentile(0.99);
  message.p999_ns = histogram.Percentile(0.999);
  message.max_ns = histogram.max();
  return message;
}

void Accumulate(const SkippedTicks& from, SkippedTicks* to) {
  to->late_wake_up += from.late_wake_up;
  to->long_compute += from.long_compute;
  to->stalled += from.stalled;
}

/// Events a second between the first and the last of them, which close `count - 1` periods.
double Rate(std::uint64_t count, Nanoseconds first, Nanoseconds last) {
  return count > 1 && last > first ? static_cast<double>(count - 1) / ToSeconds(last - first) : 0;
}

}  // namespace

SessionStatistics::SessionStatistics(Nanoseconds haptic_period) : haptic_period_(haptic_period) {}

void SessionStatistics::Hold(std::uint64_t periods) {
  for (ToolHold& hold : holds_) {
    if (!hold.contact) continue;
    hold.contact_periods += periods;
    hold.force_periods += hold.force * static_cast<double>(periods);
  }
}

void SessionStatistics::Add(const HapticSample& sample) {
  if (total_.ticks == 0) {
    first_tick_ns_ = sample.time_ns;
  } else {
    const std::uint64_t periods = sample.tick > last_tick_ ? sample.tick - last_tick_ : 0;
    Hold(periods);
    const std::uint64_t accounted = std::uint64_t{sample.skipped.Total()} + 1;
    if (periods > accounted) total_.ticks_lost += periods - accounted;
  }
  last_tick_ = sample.tick;
  last_tick_ns_ = sample.time_ns;
  ++total_.ticks;
  ++interval_.ticks;
  Accumulate(sample.skipped, &total_.skipped);
  Accumulate(sample.skipped, &interval_.skipped);
  for (auto* wake_late : {&total_.wake_late, &interval_.wake_late}) {
    wake_late->Add(sample.wake_late_ns);
  }
  for (auto* compute : {&total_.compute, &interval_.compute}) compute->Add(sample.compute_ns);
  if (sample.patch_number > 0) {
    for (auto* age : {&total_.patch_age, &interval_.patch_age}) age->Add(sample.patch_age_ns);
  }

  total_.tool_count = sample.tool_count;
  for (int i = 0; i < sample.tool_count; ++i) {
    const ToolSample& tool = sample.tools[i];
    holds_[i].force = tool.force_W.norm();
    holds_[i].contact = tool.kind != ContactKind::kNone;
    ToolSummary& summary = total_.tools[i];
    summary.peak_force = std::max(summary.peak_force, holds_[i].force);
    summary.deepest_press = std::max(summary.deepest_press, tool.depth);
  }
}

void SessionStatistics::Add(const StepRecord& step) {
  if (total_.steps == 0) first_step_ns_ = step.time_ns;
  if (step.number > last_step_ + 1) {
    const std::uint64_t lost = step.number - last_step_ - 1;
    total_.steps_lost += lost;
    if (total_.steps > 0) lost_between_ += lost;
    interval_.steps_lost += static_cast<std::int64_t>(lost);
  }
  last_step_ = step.number;
  last_step_ns_ = step.time_ns;
  ++total_.steps;
  ++interval_.steps;
  total_.step_compute.Add(step.compute_ns);
  interval_.step_compute.Add(step.compute_ns);
}

void SessionStatistics::CloseInterval(Nanoseconds end, stats_t* stats) {
  const Interval& i = interval_;
  const double seconds = ToSeconds(end - i.start);
  stats->time_ns = end;
  stats->interval_ns = end - i.start;
  stats->haptic.cycles = i.ticks;
  stats->haptic.missed = i.skipped.Total();
  stats->haptic.rate_hz = seconds > 0 ? static_cast<double>(i.ticks) / seconds : 0;
  stats->haptic.compute = ToMessage(i.compute);
  stats->deformation.cycles = i.steps;
  stats->deformation.missed = i.steps_lost;
  stats->deformation.rate_hz = seconds > 0 ? static_cast<double>(i.steps) / seconds : 0;
  stats->deformation.compute = ToMessage(i.step_compute);
  stats->wake_late = ToMessage(i.wake_late);
  stats->patch_age = ToMessage(i.patch_age);
  stats->skipped_late_wake_up = i.skipped.late_wake_up;
  stats->skipped_long_compute = i.skipped.long_compute;
  stats->skipped_stalled = i.skipped.stalled;
  interval_ = Interval();
  interval_.start = end;
}

SessionSummary SessionStatistics::Summary() const {
  SessionStatistics closed = *this;
  closed.Hold(1);
  SessionSummary summary = closed.total_;
  for (int i = 0; i < summary.tool_count; ++i) {
    const ToolHold& hold = closed.holds_[i];
    ToolSummary& tool = summary.tools[i];
    tool.contact_time = static_cast<double>(hold.contact_periods) * ToSeconds(haptic_period_);
    if (hold.contact_periods > 0) {
      tool.mean_force = hold.force_periods / static_cast<double>(hold.contact_periods);
    }
  }
  summary.haptic_hz = Rate(summary.ticks + summary.ticks_lost, first_tick_ns_, last_tick_ns_);
  summary.deformation_hz =
      Rate(summary.steps + closed.lost_between_, first_step_ns_, last_step_ns_);
  return summary;
}

}  // namespace hpdm
