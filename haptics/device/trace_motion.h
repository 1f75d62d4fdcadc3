#pragma once

#include <cstddef>
#include <vector>

#include "haptics/device/trace_file.h"
#include "haptics/device/trace_track.h"

namespace hpdm {

/// Continuous motion through the rows of a trace.
///
/// A pause P = max(50 ms, 4 times the median interval between rows) separates artefacts of the
/// recorder from motion of the hand:
///
///   repeats  A recorder that is faster than its source writes the last value again. Repeats
///            shorter than P are dropped; otherwise the motion would be a staircase. After P the
///            hand is at rest, and the first and the last repeat are kept. The tip's place, the
///            roll and the jaw are treated separately.
///   gaps     Between rows farther apart than P the recorder was off (a pedal, a lost link). The
///            hand is assumed to rest at both ends and to move between them with minimum jerk
///            (Flash and Hogan 1985). An instrument that vanishes or jumps would give forces that
///            no hand has felt.
///   between  Cubic Hermite pieces. The slope at a row is the harmonic mean of the two secants, or
///            0 if their signs differ (Fritsch and Butland 1984); it is 0 at gaps and at the ends.
///
/// Each value and its first derivative are continuous. A value stays within the range of its two
/// neighbouring rows and is never faster than twice their secant (1.875 times in a gap). It is
/// constant before the first row and after the last one.
///
/// Constant after construction; any thread may read it.
class TraceMotion {
 public:
  /// `rows`: at least one, in order of time, as ReadTraceFile returns them. Allocates.
  explicit TraceMotion(const std::vector<TraceRow>& rows);

  /// A reader's position in each track; one per reader.
  struct Cursor {
    std::size_t place = 0, roll = 0, jaw = 0;
  };
  /// Returns the values (TraceRow::values) at `time` since the first row. Wait-free, no allocation.
  JointVector At(Nanoseconds time, Cursor* cursor) const noexcept;

  using Places = TraceTrack<3>;
  /// The first three values at the rows without repeats, and at the ends of rests.
  const std::vector<Places::Knot>& places() const { return place_.knots(); }

  Nanoseconds duration() const { return duration_; }
  struct Gaps {
    std::size_t count = 0;
    Nanoseconds longest_ns = 0;
  };
  Gaps gaps() const { return gaps_; }
  /// Largest |secant| of the first three values outside gaps: m/s for tips in m.
  double fastest() const { return place_.Fastest(); }

 private:
  Places place_;
  TraceTrack<1> roll_, jaw_;
  Nanoseconds duration_ = 0;
  Gaps gaps_;
};

}  // namespace hpdm
