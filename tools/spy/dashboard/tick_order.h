#pragma once

#include "engine/base/types.h"

namespace hpdm {

/// Tells the ticks of one session from those of another that speaks on the same channel, and from
/// damaged times, by the session clock alone. One thread.
class TickOrder {
 public:
  /// A clock that jumps by more belongs to another session, or the ticks between are missing.
  static constexpr Nanoseconds kJump = kNanosecondsPerSecond;
  /// So many older ticks with no newer one between them are a session that began anew.
  static constexpr int kRestartRun = 100;
  /// Newer ticks that came between older ones: so many tell that two sessions speak,
  static constexpr int kReturns = 10;
  /// and they do no more once so much of the newer one's time has passed without.
  static constexpr Nanoseconds kForgetAfter = 3 * kNanosecondsPerSecond;

  enum class Verdict {
    kFollows,  ///< The session's next.
    kAhead,    ///< A jump ahead: the session's if the next one follows it, which tells kFollows.
    kStray,    ///< Not the session's.
    kAnew      ///< The first of the session that is heard from now on.
  };

  Verdict Judge(Nanoseconds time);

  bool two_sessions() const { return returns_ >= kReturns; }

 private:
  bool any_ = false, ahead_ = false;
  Nanoseconds newest_ = 0;
  Nanoseconds ahead_time_ = 0;  // of the one tick ahead
  int run_ = 0;                 // older ticks
  int returns_ = 0;
  Nanoseconds last_return_ = 0;
};

}  // namespace hpdm
