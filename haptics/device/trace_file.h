#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "engine/snapshots.h"

/// Recorded motions of an instrument, as CSV:
///
///     t,px,py,pz,jaw
///     0.000,0.343647,-0.089301,0.156684,1.000
///
/// The first line names the columns, in any order:
///
///   t                     s, any start; required
///   px, py, pz            the tip's centre, in a frame that the scene places (m, or scaled), or
///   pitch, yaw, insertion the device's joints (rad, rad, m), or neither: the tip stands still
///   roll                  rad; absent: 0. A jump of more than pi is taken as a wrapped turn and
///                         unwrapped
///   jaw                   0 closed .. 1 open; absent: open
///
/// Other columns are ignored. Lines that start with # or % and blank lines are comments. A byte
/// order mark and CRLF line ends are accepted. Rows may have any rate, with gaps, and may repeat a
/// pose (see trace_motion.h). If rows have the same time, the last counts.
namespace hpdm {

/// Meaning of the first three values of a row.
enum class TracePlace { kTip, kJoints, kNone };

struct TraceRow {
  Nanoseconds time_ns = 0;                   ///< Since the first row; strictly rising.
  JointVector values = JointVector::Zero();  ///< Tip (x, y, z) or pitch, yaw, insertion, or 0; then
                                             ///< roll and jaw.
};

struct TraceFile {
  std::string path;
  TracePlace place = TracePlace::kNone;
  std::vector<TraceRow> rows;               ///< At least one.
  std::vector<std::string> unread_columns;  ///< Names of unknown columns.
};

/// A million rows are a quarter of an hour at 1 kHz and 48 MB.
inline constexpr std::size_t kMaxTraceRows = 1'000'000;
inline constexpr std::size_t kMaxTraceLine = 4096;  ///< Bytes.

/// Reads a trace. Set-up only. Uses no more memory than the limits above allow, for any file.
///
/// Throws InputError, `FILE:LINE: fault; remedy` on one line, at the first of these faults:
/// - no such file, no header, or a file or line beyond the limits;
/// - a column that is missing or named twice;
/// - a row with more or fewer cells than the header;
/// - a cell that is not a finite number (a decimal comma);
/// - a time that goes backwards.
TraceFile ReadTraceFile(const std::string& path);

}  // namespace hpdm
