#include "lcmtypes/telemetry/step_matcher.h"

namespace hpdm {
namespace {

std::uint64_t NumberOf(const contact_t& step) { return static_cast<std::uint64_t>(step.step); }

}  // namespace

void StepMatcher::AddStep(contact_t step) {
  const std::uint64_t number = NumberOf(step);
  while (!first_uses_.empty() && first_uses_.front().first < number) first_uses_.pop_front();
  if (!first_uses_.empty() && first_uses_.front().first == number) {
    Write(&step, static_cast<std::int64_t>(first_uses_.front().second));
    first_uses_.pop_front();
  } else if (number < newest_used_) {
    Write(&step, kNeverVisible);
  } else {
    waiting_.push_back(std::move(step));
    if (waiting_.size() <= kMaxWaiting) return;
    Write(&waiting_.front(), kNeverVisible);
    waiting_.pop_front();
  }
}

void StepMatcher::AddFirstUse(std::uint64_t patch_number, std::uint64_t tick) {
  if (patch_number <= newest_used_) return;
  newest_used_ = patch_number;
  bool found = false;
  // Waiting steps before that one were replaced unused.
  while (!waiting_.empty() && NumberOf(waiting_.front()) <= patch_number) {
    found = NumberOf(waiting_.front()) == patch_number;
    Write(&waiting_.front(), found ? static_cast<std::int64_t>(tick) : kNeverVisible);
    waiting_.pop_front();
  }
  if (!found) first_uses_.emplace_back(patch_number, tick);
}

void StepMatcher::Finish() {
  for (contact_t& step : waiting_) Write(&step, kNeverVisible);
  waiting_.clear();
}

void StepMatcher::Write(contact_t* step, std::int64_t visible_tick) {
  step->visible_tick = visible_tick;
  write_(step);
}

}  // namespace hpdm
