#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "engine/snapshots.h"

namespace hpdm {

/// Name of the event that follows session.start in a log that holds only a part of the outputs.
inline constexpr std::string_view kLogThinned = "log.thinned";

/// Returns the text of kLogThinned: "one output in 10 ticks is in the log, ...".
std::string ThinnedText(int interval);

/// Returns the interval of ThinnedText; 1 for any other text.
int ThinnedInterval(std::string_view text);

/// Counts ticks in intervals: ticks 0 .. interval - 1 are the first.
class TickIntervals {
 public:
  /// `ticks`: length of an interval, at least 1.
  explicit TickIntervals(int ticks) : ticks_(static_cast<std::uint64_t>(ticks)) {}
  /// True if no earlier tick was in the interval of `tick`. Ticks must rise.
  bool Begins(std::uint64_t tick) {
    const std::uint64_t number = tick / ticks_;
    if (last_ == number) return false;
    last_ = number;
    return true;
  }

 private:
  std::uint64_t ticks_;
  std::optional<std::uint64_t> last_;
};

/// Selects the ticks whose outputs a thinned log holds:
///
/// 1. the first tick of each interval, so the log lacks an output if an interval has none;
/// 2. ticks whose contact, organ or guard state (forces off, clamped) differs from the tick before;
/// 3. ticks with more force or depth at an organ than all ticks before.
///
/// So a report has exact contacts and peaks, though not every force. One thread; allocates nothing.
class OutputThinning {
 public:
  /// `interval`: ticks, at least 1; 1 selects every tick.
  explicit OutputThinning(int interval) : intervals_(interval) {}
  bool Selects(const HapticSample& sample);

 private:
  struct Tool {
    ContactKind kind = ContactKind::kNone;
    int organ = -1;
    std::uint32_t guard = 0;
    std::array<double, kMaxOrgans + 1> peak_force{};  // N, by organ; the last: none
    std::array<double, kMaxOrgans + 1> peak_depth{};  // m
  };
  static bool Update(const ToolSample& sample, Tool* tool);

  TickIntervals intervals_;
  std::array<Tool, kMaxInstruments> tools_;
};

}  // namespace hpdm
