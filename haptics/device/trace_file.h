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
///   roll                  rad; absent: 0. A jump of more than pi is a turn that the recorder
///                         wrapped, and is undone
///   jaw                   0 closed .. 1 open; absent: open
///
/// Other columns are not read. Lines that start with # or % and blank lines are comments; a byte
/// order mark and CRLF line ends are taken. Rows may come at any rate, with gaps, and may repeat a
/// pose (trace_motion.h says what that means); of rows with the same time the last counts.
namespace hpdm {

/// What the first three values of a row are.
enum class TracePlace { kTip, kJoints, kNone };

struct TraceRow {
  Nanoseconds time_ns = 0;                   ///< Since the first row; rises from row to row.
  JointVector values = JointVector::Zero();  ///< Tip (x, y, z) or pitch, yaw, insertion, or 0; then
                                             ///< roll and jaw.
};

struct TraceFile {
  std::string path;
  TracePlace place = TracePlace::kNone;
  std::vector<TraceRow> rows;               ///< At least one.
  std::vector<std::string> unread_columns;  ///< Columns that nothing is known of.
};

/// A million rows are a quarter of an hour at 1 kHz and 48 MB.
inline constexpr std::size_t kMaxTraceRows = 1'000'000;
inline constexpr std::size_t kMaxTraceLine = 4096;  ///< Bytes.

/// Reads a trace. Throws InputError, `FILE:LINE: what is wrong; remedy` on one line, at the first
/// fault: no such file, no header, a column missing or named twice, a row with more or fewer cells
/// than the header, a cell that is not a finite number (a decimal comma), a time that runs back, a
/// line or a file beyond the limits above. Reserves no more memory than those allow, whatever the
/// file holds. Set-up only.
TraceFile ReadTraceFile(const std::string& path);

}  // namespace hpdm
