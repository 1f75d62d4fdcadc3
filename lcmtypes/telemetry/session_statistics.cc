#include "lcmtypes/telemetry/session_statistics.h"

#include <algorithm>

#include "engine/threads/loop_schedule.h"
#include "lcmtypes/analysis/tissue_force.h"

namespace hpdm {
namespace {

// The message names the distributions by the same indices.
static_assert(static_cast<int>(Latency::kBaselineWakeUp) == 11 && kLatencyCount == 12);

distribution_t ToMessage(const Histogram& histogram) {
  distribution_t message;
  message.count = static_cast<std::int64_t>(histogram.count());
  message.p50_ns = histogram.Percentile(0.5);
  message.p99_ns = histogram.Percentile(0.99);
  message.p999_ns = histogram.Percentile(0.999);
  message.max_ns = histogram.max();
  return message;
}

void AddBins(std::size_t distribution, const Histogram& histogram, stats_t* stats) {
  histogram.ForEachBin([&](std::int64_t upper_ns, std::uint64_t count) {
    bin_t& bin = stats->bins.emplace_back();
    bin.distribution = static_cast<std::int8_t>(distribution);
    bin.upper_ns = upper_ns;
    bin.count = static_cast<std::int32_t>(count);
  });
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

SessionStatistics::SessionStatistics(Nanoseconds haptic_period, const Histogram& baseline)
    : haptic_period_(haptic_period) {
  total_.latencies[Latency::kBaselineWakeUp] = baseline;
}

void SessionStatistics::Count(Latency which, Nanoseconds duration) {
  total_.latencies[which].Add(duration);
  interval_.latencies[which].Add(duration);
}

void SessionStatistics::Hold(std::uint64_t periods) {
  for (ToolHold& hold : holds_) {
    if (!hold.contact) continue;
    hold.contact_periods += periods;
    hold.force_periods += hold.force * static_cast<double>(periods);
  }
}

void SessionStatistics::Add(const HapticSample& sample) {
  const Nanoseconds wake_up_ns = sample.time_ns + sample.wake_late_ns;
  if (total_.ticks == 0) {
    first_tick_ns_ = sample.time_ns;
  } else {
    const std::uint64_t periods = sample.tick > last_tick_ ? sample.tick - last_tick_ : 0;
    Hold(periods);
    const std::uint64_t accounted = std::uint64_t{sample.skipped.Total()} + 1;
    if (periods > accounted) {
      total_.ticks_lost += periods - accounted;  // and with them, when the last one woke
    } else {
      Count(Latency::kHapticPeriod, wake_up_ns - last_wake_up_ns_);
    }
  }
  // The session's time runs while its threads start: rates begin with the first tick.
  if (total_.ticks == 0) interval_.start = std::max(interval_.start, sample.time_ns);
  last_tick_ = sample.tick;
  last_tick_ns_ = sample.time_ns;
  last_wake_up_ns_ = wake_up_ns;
  ++total_.ticks;
  ++interval_.ticks;
  Accumulate(sample.skipped, &total_.skipped);
  Accumulate(sample.skipped, &interval_.skipped);
  Count(Latency::kHapticWakeUp,
        WakeUpLateness(sample.wake_late_ns, sample.skipped, haptic_period_));
  Count(Latency::kHapticCompute, sample.compute_ns);
  // What starts at a device sample says nothing while the devices are not read.
  if (sample.paused) paused_until_ns_ = wake_up_ns;
  if (sample.patch_number > 0 && sample.time_ns - sample.patch_age_ns > paused_until_ns_) {
    Count(Latency::kPatchAge, sample.patch_age_ns);
  }
  for (int i = 0; i < sample.tool_count; ++i) {
    const ToolSample& tool = sample.tools[i];
    if (!tool.device_valid || tool.device_time_ns <= paused_until_ns_) continue;
    Count(Latency::kDeviceToForce, wake_up_ns + sample.written_ns - tool.device_time_ns);
  }

  total_.tool_count = sample.tool_count;
  for (int i = 0; i < sample.tool_count; ++i) {
    const ToolSample& tool = sample.tools[i];
    holds_[i].force = TissueForce(tool).norm();
    holds_[i].contact = tool.kind != ContactKind::kNone;
    ToolSummary& summary = total_.tools[i];
    summary.peak_force = std::max(summary.peak_force, holds_[i].force);
    summary.deepest_press = std::max(summary.deepest_press, tool.depth);
    holds_[i].slips.Add(ToSeconds(sample.time_ns), tool.slip);
    summary.slips = holds_[i].slips.count();
  }
}

void SessionStatistics::Add(const StepRecord& step) {
  const Nanoseconds wake_up_ns = step.time_ns + step.wake_late_ns;
  if (total_.steps == 0) first_step_ns_ = step.time_ns;
  if (step.number > last_step_ + 1) {
    const std::uint64_t lost = step.number - last_step_ - 1;
    total_.steps_lost += lost;
    if (total_.steps > 0) lost_between_ += lost;
    interval_.steps_lost += static_cast<std::int64_t>(lost);
  } else if (total_.steps > 0) {
    Count(Latency::kDeformationPeriod, wake_up_ns - last_step_wake_up_ns_);
  }
  last_step_ = step.number;
  last_step_ns_ = step.time_ns;
  last_step_wake_up_ns_ = wake_up_ns;
  ++total_.steps;
  ++interval_.steps;
  if ((step.flags & kStepShed) != 0) {
    ++total_.steps_shed;
    ++interval_.steps_shed;
  }
  Count(Latency::kDeformationWakeUp, step.wake_late_ns);
  Count(Latency::kDeformationCompute, step.compute_ns);
}

void SessionStatistics::Add(const FrameRecord& frame) {
  if (total_.frames > 0) Count(Latency::kRenderPeriod, frame.time_ns - last_picture_ns_);
  last_picture_ns_ = frame.time_ns;
  ++total_.frames;
  ++interval_.frames;
  Count(Latency::kRenderCompute, frame.compute_ns);
  if (frame.device_time_ns > paused_until_ns_) {
    Count(Latency::kDeviceToPhoton, frame.time_ns - frame.device_time_ns);
  }
}

void SessionStatistics::AddStolen(Nanoseconds stolen) {
  total_.stolen_ns += stolen;
  interval_.stolen += stolen;
}

void SessionStatistics::CloseInterval(Nanoseconds end, stats_t* stats) {
  const Interval& i = interval_;
  const double seconds = ToSeconds(end - i.start);
  const auto rate = [&](std::int64_t cycles) {
    return seconds > 0 ? static_cast<double>(cycles) / seconds : 0;
  };
  stats->time_ns = end;
  stats->interval_ns = end - i.start;
  stats->haptic.cycles = i.ticks;
  stats->haptic.missed = i.skipped.Total();
  stats->haptic.rate_hz = rate(i.ticks);
  stats->deformation.cycles = i.steps;
  stats->deformation.missed = i.steps_lost;
  stats->deformation.rate_hz = rate(i.steps);
  stats->render.cycles = i.frames;
  stats->render.rate_hz = rate(i.frames);
  stats->bins.clear();
  i.latencies.ForEach([&](std::size_t index, const Histogram& histogram) {
    stats->latencies[index] = ToMessage(histogram);
    AddBins(index, histogram, stats);
  });
  constexpr Latency kBaseline = Latency::kBaselineWakeUp;
  constexpr auto kBaselineIndex = static_cast<std::size_t>(kBaseline);
  stats->latencies[kBaselineIndex] = ToMessage(total_.latencies[kBaseline]);
  if (!baseline_sent_) AddBins(kBaselineIndex, total_.latencies[kBaseline], stats);
  baseline_sent_ = true;
  stats->bin_count = static_cast<std::int32_t>(stats->bins.size());
  stats->stolen_ns = i.stolen;
  stats->steps_shed = i.steps_shed;
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
