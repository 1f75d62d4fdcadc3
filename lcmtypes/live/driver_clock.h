#pragma once

#include <algorithm>
#include <cstdint>

#include "engine/base/types.h"

namespace hpdm {

/// Puts the time stamps of another clock, whose zero means nothing, into session time.
///
/// A reading stamped d arrives at session time a = d + offset + delay with delay >= 0, so the
/// smallest a - d seen is the offset plus the shortest delay: readings keep the spacing at which
/// their driver took them, free of the network's jitter, and are at most that shortest delay too
/// young. The estimate rises by 200 ppm of the time that passes, more than two crystals part, so
/// that it follows a slower clock too. A stamp that would lie kBroken or more before its arrival is
/// of another clock (the driver was started anew): the estimate begins again.
///
/// One thread; wait-free.
class DriverClock {
 public:
  /// Stamps beyond this (146 years) are of no clock.
  static constexpr Nanoseconds kMaxStamp = Nanoseconds{1} << 62;
  static constexpr Nanoseconds kBroken = 100'000'000;

  /// Session time of `stamp`, which arrived at `arrival`: never above it, and never below an
  /// earlier answer. |stamp| <= kMaxStamp; arrivals do not fall.
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
