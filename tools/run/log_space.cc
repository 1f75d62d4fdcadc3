#include "tools/run/log_space.h"

#include <algorithm>

#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

// Sizes of the messages with their headers, bytes.
constexpr double kInput = 103, kInputOfInstrument = 102;
constexpr double kOutput = 106, kOutputOfInstrument = 105;
// Bytes a second of the steps and of their shapes, of which a thinned log has fewer. Measured on the
// shipped scenes and rounded up.
constexpr double kSteps = 35e3, kShapes = 110e3;
constexpr double kShapeRate = 30;     // Hz
constexpr double kOpenLength = 1800;  // s

std::string Megabytes(double bytes) {
  return bytes < 1e10 ? Format("%.0f MB", bytes / 1e6) : Format("%.0f GB", bytes / 1e9);
}

// Seconds below two minutes, else minutes; two digits are enough for an estimate.
std::string Length(double seconds) {
  if (seconds >= 120) return Format("%.0f min", seconds / 60);
  return seconds < 10 ? Format("%.2g s", seconds) : Format("%.0f s", seconds);
}

}  // namespace

double LogBytesPerSecond(std::size_t instruments, int haptic_hz, int output_interval) {
  const auto n = static_cast<double>(instruments);
  const double output_hz = static_cast<double>(haptic_hz) / output_interval;
  return haptic_hz * (kInput + n * kInputOfInstrument) +
         output_hz * (kOutput + n * kOutputOfInstrument) + kSteps +
         kShapes * std::min(1.0, output_hz / kShapeRate);
}

std::string LogSpaceRemark(double bytes_per_second, double seconds, std::uintmax_t available) {
  const double room = static_cast<double>(available);
  const double needed = bytes_per_second * (seconds > 0 ? seconds : kOpenLength);
  if (room >= needed) return {};
  return "the disk has " + Megabytes(room) + " free, enough for about " +
         Length(room / bytes_per_second) + " of the log, which grows by " +
         Megabytes(60 * bytes_per_second) + " a minute" +
         (seconds > 0 ? ", and not for " + Length(seconds) : "") +
         "; free space, choose a folder on another disk with --out, or log less with --log-rate";
}

}  // namespace hpdm
