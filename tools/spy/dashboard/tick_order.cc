#include "tools/spy/dashboard/tick_order.h"

#include <algorithm>

namespace hpdm {
namespace {

// Returns b - a, in double precision because the difference of damaged times may exceed 64 bits.
double Later(Nanoseconds a, Nanoseconds b) {
  return static_cast<double>(b) - static_cast<double>(a);
}

}  // namespace

TickOrder::Verdict TickOrder::Judge(Nanoseconds time) {
  const double jump = static_cast<double>(kJump);
  if (!any_) {
    any_ = true;
    newest_ = time;
    return Verdict::kFollows;
  }
  if (Later(newest_, time) < -jump) {
    ahead_ = false;
    if (++run_ < kRestartRun) return Verdict::kStray;
    *this = {};
    any_ = true;
    newest_ = time;
    return Verdict::kRestart;
  }
  if (Later(newest_, time) > jump) {
    const bool follows = ahead_ && time >= ahead_time_ && Later(ahead_time_, time) <= jump;
    ahead_ = true;
    ahead_time_ = time;
    if (!follows) return Verdict::kAhead;
  }
  ahead_ = false;
  newest_ = std::max(newest_, time);
  const bool returned = run_ > 0;
  run_ = 0;
  if (Later(last_return_, newest_) > static_cast<double>(kForgetAfter)) returns_ = 0;
  if (returned) {
    returns_ = std::min(returns_ + 1, kReturns);
    last_return_ = newest_;
  }
  return Verdict::kFollows;
}

}  // namespace hpdm
