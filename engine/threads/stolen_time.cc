#include "engine/threads/stolen_time.h"

#include <fcntl.h>
#include <unistd.h>

#include <charconv>

namespace hpdm {

Nanoseconds StolenTimeIn(std::string_view proc_stat, long ticks_per_second) noexcept {
  constexpr int kStealField = 8;  // of the numbers after "cpu", from 1
  if (!proc_stat.starts_with("cpu ") || ticks_per_second <= 0) return 0;
  const char* at = proc_stat.data() + 4;
  const char* const end = proc_stat.data() + proc_stat.size();
  long long ticks = 0;
  for (int field = 1; field <= kStealField; ++field) {
    while (at != end && *at == ' ') ++at;
    const auto [next, error] = std::from_chars(at, end, ticks);
    if (error != std::errc()) return 0;
    at = next;
  }
  return ticks * (kNanosecondsPerSecond / ticks_per_second);
}

Nanoseconds StolenTime() noexcept {
  const int file = open("/proc/stat", O_RDONLY | O_CLOEXEC);
  if (file < 0) return 0;
  char text[256];  // the first line has ten numbers
  const ssize_t size = read(file, text, sizeof text);
  close(file);
  if (size <= 0) return 0;
  return StolenTimeIn({text, static_cast<std::size_t>(size)}, sysconf(_SC_CLK_TCK));
}

}  // namespace hpdm
