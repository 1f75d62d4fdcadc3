#pragma once

#include "engine/base/types.h"

namespace hpdm {

/// Separates the ticks of one session from those of another one on the same channel, and from
/// damaged times, by the session clock alone. One thread.
class TickOrder {
 public:
  /// After a larger jump of the clock, ticks are missing or belong to another session.
  static constexpr Nanoseconds kJump = kNanosecondsPerSecond;
  /// This many older ticks without a newer one between them mean that a new session began.
  static constexpr int kRestartRun = 100;
  /// This many newer ticks between older ones mean that there are two sessions.
  static constexpr int kReturns = 10;
  /// The count of such ticks is reset after this time of the newer session without one.
  static constexpr Nanoseconds kForgetAfter = 3 * kNanosecondsPerSecond;

  enum class Verdict {
    kFollows,  ///< The session's next tick.
    kAhead,    ///< A jump ahead; it belongs to the session if the next tick is kFollows.
    kStray,    ///< Not a tick of the session.
    kRestart   ///< The first tick of a new session.
  };

  Verdict Judge(Nanoseconds time);

  bool two_sessions() const { return returns_ >= kReturns; }

 private:
  bool any_ = false, ahead_ = false;
  Nanoseconds newest_ = 0;
  Nanoseconds ahead_time_ = 0;  // time of the tick that jumped ahead
  int run_ = 0;                 // number of older ticks in a row
  int returns_ = 0;             // newer ticks between older ones
  Nanoseconds last_return_ = 0;
};

}  // namespace hpdm
