#pragma once

#include <cstddef>
#include <vector>

#include "haptics/device/trace_file.h"
#include "haptics/device/trace_track.h"

namespace hpdm {

/// The continuous motion that a trace's rows stand for.
///
/// A pause P = max(50 ms, 4 times the median interval between rows) separates what a recorder does
/// from what a hand does:
///
///   repeats  A recorder that is faster than its source writes the last value again. Repeats that
///            last less than P are dropped, or the motion would be a staircase; from P on the hand
///            is at rest, and the first and the last of them stay. The tip's place, the roll and
///            the jaw repeat on their own.
///   gaps     Between rows further apart than P the recorder was off (a pedal, a lost link). The
///            hand is taken to rest at both ends and to move between them with minimum jerk (Flash
///            and Hogan 1985): an instrument that vanishes, or that jumps when it is back, would
///            teach a force that no hand has felt.
///   between  Cubic Hermite pieces whose slope at a row is the harmonic mean of the two secants, or
///            0 where they disagree in sign (Fritsch and Butland 1984); 0 at gaps and at the ends.
///
/// So each value is continuous with its first derivative over all times, never leaves the range of
/// the two rows kept that it lies between, and is never faster than twice their secant (1.875 times
/// in a gap). Before the first row and after the last one it stands still.
///
/// Constant after construction; any thread may read it.
class TraceMotion {
 public:
  /// `rows`: at least one, in time, as ReadTraceFile gives them. Allocates.
  explicit TraceMotion(const std::vector<TraceRow>& rows);

  /// Where a reader was in each track; one a reader.
  struct Cursor {
    std::size_t place = 0, roll = 0, jaw = 0;
  };
  /// Values (TraceRow::values) at `time` since the first row. Wait-free, no allocation.
  JointVector At(Nanoseconds time, Cursor* cursor) const noexcept;

  using Places = TraceTrack<3>;
  /// The first three values at the rows that are no repeats, and at the ends of rests.
  const std::vector<Places::Knot>& places() const { return place_.knots(); }

  Nanoseconds duration() const { return duration_; }
  struct Gaps {
    std::size_t count = 0;
    Nanoseconds longest_ns = 0;
  };
  Gaps gaps() const { return gaps_; }
  /// Largest |secant| of the first three values, gaps left out: m/s for tips in m.
  double fastest() const { return place_.Fastest(); }

 private:
  Places place_;
  TraceTrack<1> roll_, jaw_;
  Nanoseconds duration_ = 0;
  Gaps gaps_;
};

}  // namespace hpdm
