#include "lcmtypes/telemetry/health_publisher.h"

#include "lcmtypes/analysis/tissue_force.h"

namespace hpdm {
namespace {

constexpr Nanoseconds kHealthPeriod = kNanosecondsPerSecond / 10;

}  // namespace

void HealthPublisher::Add(const HapticSample& sample) {
  health_.tool_count = sample.tool_count;
  for (int i = 0; i < sample.tool_count; ++i) {
    const ToolSample& tool = sample.tools[i];
    health_.tools[i].force_W = TissueForce(tool);
    health_.tools[i].depth = tool.depth;
    health_.tools[i].organ = tool.organ;
    health_.tools[i].guard_flags = tool.guard_flags;
  }
}

void HealthPublisher::Add(const StepRecord& step) {
  health_.step_compute_ns = step.compute_ns;
  health_.step_flags = step.flags;
}

void HealthPublisher::Add(const stats_t& interval) {
  health_.haptic_hz = interval.haptic.rate_hz;
  health_.deformation_hz = interval.deformation.rate_hz;
  health_.wake_late_p99_ns =
      interval.latencies[static_cast<std::size_t>(Latency::kHapticWakeUp)].p99_ns;
}

void HealthPublisher::Publish(Nanoseconds now, const SessionSummary& sums, std::uint64_t log_lost) {
  if (out_ == nullptr || now < health_.time_ns + kHealthPeriod) return;
  health_.time_ns = now;
  health_.ticks = sums.ticks;
  health_.skipped = sums.skipped;
  health_.log_lost = log_lost;
  for (int i = 0; i < health_.tool_count; ++i)
    health_.tools[i].peak_force = sums.tools[i].peak_force;
  out_->Back() = health_;
  out_->Publish();
}

}  // namespace hpdm
