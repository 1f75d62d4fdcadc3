#include <algorithm>
#include <cmath>

#include "haptics/device/trace_file.h"
#include "haptics/device/trace_motion.h"
#include "tests/fuzz/input_file.h"

namespace hpdm::fuzz {
namespace {

void EnsureSound(const TraceFile& trace) {
  HPDM_ENSURE(!trace.rows.empty() && trace.rows.size() <= kMaxTraceRows);
  HPDM_ENSURE(trace.rows.front().time_ns == 0);
  for (std::size_t i = 0; i < trace.rows.size(); ++i) {
    HPDM_ENSURE(trace.rows[i].values.allFinite());
    HPDM_ENSURE(i == 0 || trace.rows[i].time_ns > trace.rows[i - 1].time_ns);
  }
  for (const std::string& name : trace.unread_columns) {
    HPDM_ENSURE(std::all_of(name.begin(), name.end(), [](char c) { return c >= ' ' && c <= '~'; }));
  }
}

/// At every row, between rows and beyond the ends, the motion stays within the range of the rows.
void EnsureWithin(const TraceMotion& motion, const TraceFile& trace) {
  JointVector low = trace.rows[0].values, high = low;
  for (const TraceRow& row : trace.rows) {
    low = low.cwiseMin(row.values);
    high = high.cwiseMax(row.values);
  }
  HPDM_ENSURE(motion.duration() == trace.rows.back().time_ns);
  HPDM_ENSURE(std::isfinite(motion.fastest()));
  TraceMotion::Cursor cursor;
  const auto ensure_at = [&](Nanoseconds time) {
    const JointVector values = motion.At(time, &cursor);
    HPDM_ENSURE((values.array() >= low.array()).all() && (values.array() <= high.array()).all());
  };
  ensure_at(-1);
  for (std::size_t i = 0; i + 1 < trace.rows.size(); ++i) {
    const Nanoseconds from = trace.rows[i].time_ns, to = trace.rows[i + 1].time_ns;
    for (const Nanoseconds time : {from, from + (to - from) / 2, to - 1}) ensure_at(time);
  }
  ensure_at(motion.duration() + 1);
  ensure_at(motion.duration() / 2);  // back: not the next place
}

}  // namespace

bool TraceCsv(Bytes bytes) {
  static const InputFile file("trace.csv");
  file.Write(bytes);
  try {
    const TraceFile trace = ReadTraceFile(file.path());
    EnsureSound(trace);
    EnsureWithin(TraceMotion(trace.rows), trace);
    return true;
  } catch (const InputError& error) {
    EnsureOneLine(error, file.path());
    return false;
  }
}

}  // namespace hpdm::fuzz
