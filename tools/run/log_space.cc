#include "tools/run/log_space.h"

#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

// Measured on the shipped scenes with one and with two instruments, rounded up.
constexpr double kBytesPerTick = 350;
constexpr double kBytesPerTickAndInstrument = 210;
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

double LogBytesPerSecond(std::size_t instruments, int haptic_hz) {
  return haptic_hz *
         (kBytesPerTick + kBytesPerTickAndInstrument * static_cast<double>(instruments));
}

std::string LogSpaceRemark(double bytes_per_second, double seconds, std::uintmax_t available) {
  const double room = static_cast<double>(available);
  const double needed = bytes_per_second * (seconds > 0 ? seconds : kOpenLength);
  if (room >= needed) return {};
  return "the disk has " + Megabytes(room) + " free, enough for about " +
         Length(room / bytes_per_second) + " of the log, which grows by " +
         Megabytes(60 * bytes_per_second) + " a minute" +
         (seconds > 0 ? ", and not for " + Length(seconds) : "") +
         "; free space, or choose a folder on another disk with --out";
}

}  // namespace hpdm
