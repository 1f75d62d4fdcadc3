#pragma once

#include <algorithm>
#include <cstdint>

#include "engine/base/types.h"

namespace hpdm {

/// Converts the time stamps of another clock, with any zero, to session time.
///
/// A reading stamped d arrives at session time a = d + offset + delay, with delay >= 0.
///
/// 1. The estimate of the offset is the smallest a - d seen: the offset plus the shortest delay.
/// 2. So readings keep the driver's spacing, without the network's jitter, and are at most that
///    shortest delay too young.
/// 3. The estimate rises by 200 ppm of the time that passes, more than two crystals differ. So it
///    follows a slower clock too.
/// 4. A stamp kBroken or more before its arrival belongs to another clock (a restarted driver): the
///    estimate begins again.
///
/// One thread; wait-free.
class DriverClock {
 public:
  /// Stamps beyond this (146 years) are invalid.
  static constexpr Nanoseconds kMaxStamp = Nanoseconds{1} << 62;
  static constexpr Nanoseconds kBroken = 100'000'000;

  /// Returns the session time of `stamp`, which arrived at `arrival`. It is never above `arrival`
  /// and never below an earlier result. Needs |stamp| <= kMaxStamp and arrivals that do not fall.
  Nanoseconds ToSession(Nanoseconds stamp, Nanoseconds arrival) noexcept {
    const Nanoseconds seen = arrival - stamp;
    const Nanoseconds risen = offset_ + (arrival - last_arrival_) / 5000;
    const bool begins = !started_ || seen - risen >= kBroken;
    offset_ = begins ? seen : std::min(seen, risen);
    started_ = true;
    last_arrival_ = arrival;
    last_answer_ = std::max(last_answer_, std::min(stamp + offset_, arrival));
    return last_answer_;
  }

 private:
  bool started_ = false;
  Nanoseconds offset_ = 0;
  Nanoseconds last_arrival_ = 0;
  Nanoseconds last_answer_ = 0;
};

}  // namespace hpdm
