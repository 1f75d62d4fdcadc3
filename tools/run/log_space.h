#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace hpdm {

/// Returns about how many bytes a session's log grows by in a second: 0.77 MB (46 MB a minute) with
/// two instruments at 1 kHz. `output_interval`: TelemetryOptions::output_interval.
double LogBytesPerSecond(std::size_t instruments, int haptic_hz, int output_interval);

/// Returns one line if `available` bytes are too few for the log of a session of `seconds`, or, if
/// that is 0 and its length is open, for half an hour. Else returns an empty string.
std::string LogSpaceRemark(double bytes_per_second, double seconds, std::uintmax_t available);

}  // namespace hpdm
