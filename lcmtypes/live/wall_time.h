#pragma once

#include <chrono>
#include <cstdint>

namespace hpdm {

/// The machine's clock in microseconds since 1970, as LCM stamps what arrives.
inline std::int64_t WallTimeUs() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace hpdm
