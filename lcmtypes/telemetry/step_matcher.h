#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <utility>

#include "lcmtypes/wire/codec.h"

namespace hpdm {

/// Completes each step with its visible tick: the first tick that used its patch. Steps and uses
/// cross different queues, so whichever comes first waits for the other.
///
/// Thread: that of its owner. Guarantee: each step is written once, in order, whatever is lost; at
/// most kMaxWaiting steps wait.
class StepMatcher {
 public:
  /// Steps that may wait for their first use: a second at any rate, far beyond any hand-over. While
  /// the haptic loop stands still, older ones are replaced before a tick can use them.
  static constexpr std::size_t kMaxWaiting = 1024;

  /// `write` receives every step with its visible tick, or kNeverVisible.
  explicit StepMatcher(std::function<void(contact_t*)> write) : write_(std::move(write)) {}

  /// Adds the next step.
  void AddStep(contact_t step);
  /// Adds a tick that was the first to use a patch. Repeated calls for the same patch do nothing.
  void AddFirstUse(std::uint64_t patch_number, std::uint64_t tick);
  /// Writes the waiting steps: no tick will use them.
  void Finish();

 private:
  void Write(contact_t* step, std::int64_t visible_tick);

  std::function<void(contact_t*)> write_;
  std::deque<contact_t> waiting_;
  std::deque<std::pair<std::uint64_t, std::uint64_t>> first_uses_;  // patch number, tick
  std::uint64_t newest_used_ = 0;                                   // patch number
};

}  // namespace hpdm
