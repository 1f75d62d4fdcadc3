#include "lcmtypes/telemetry/output_thinning.h"

#include <charconv>

#include "lcmtypes/analysis/tissue_force.h"

namespace hpdm {
namespace {

constexpr std::string_view kBeforeInterval = "one output in ";
constexpr std::string_view kAfterInterval =
    " ticks is in the log, and each change of contact and new peak";

/// Raises `peak` to `value`. Returns true if that is a change.
bool Raise(double value, double* peak) {
  if (!(value > *peak)) return false;
  *peak = value;
  return true;
}

}  // namespace

std::string ThinnedText(int interval) {
  return std::string(kBeforeInterval) + std::to_string(interval) + std::string(kAfterInterval);
}

int ThinnedInterval(std::string_view text) {
  if (!text.starts_with(kBeforeInterval) || !text.ends_with(kAfterInterval)) return 1;
  text.remove_prefix(kBeforeInterval.size());
  int interval = 1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), interval);
  const bool whole =
      error == std::errc() && end + kAfterInterval.size() == text.data() + text.size();
  return whole && interval > 1 ? interval : 1;
}

bool OutputThinning::Selects(const HapticSample& sample) {
  bool selected = intervals_.Begins(sample.tick);
  for (int t = 0; t < sample.tool_count; ++t) {
    const auto i = static_cast<std::size_t>(t);
    selected |= Update(sample.tools[i], &tools_[i]);
  }
  return selected;
}

/// Returns true if the tick shows something that no tick before has shown.
bool OutputThinning::Update(const ToolSample& sample, Tool* tool) {
  const std::uint32_t guard = sample.guard_flags & (kGuardDisabled | kGuardClamped);
  bool news = sample.kind != tool->kind || sample.organ != tool->organ || guard != tool->guard;
  tool->kind = sample.kind;
  tool->organ = sample.organ;
  tool->guard = guard;
  const bool known = sample.organ >= 0 && sample.organ < kMaxOrgans;
  const auto place = static_cast<std::size_t>(known ? sample.organ : kMaxOrgans);
  news |= Raise(TissueForce(sample).norm(), &tool->peak_force[place]);
  news |= Raise(sample.depth, &tool->peak_depth[place]);
  return news;
}

}  // namespace hpdm
