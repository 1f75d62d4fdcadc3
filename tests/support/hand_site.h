#pragma once

#include "haptics/device/simulated_hand.h"

namespace hpdm {

inline constexpr Nanoseconds kTick = 1'000'000;
inline constexpr Nanoseconds kSecond = kNanosecondsPerSecond;

/// A site on an organ of 0.2 m whose normal and trocar lie along no axis.
inline HandSite Site() {
  return {.p_target_W = {0.02, 0.01, 0.05},
          .normal_W = Vector3d(0.1, -0.2, 1).normalized(),
          .p_trocar_W = {0.05, -0.08, 0.2},
          .organ_size = 0.2};
}

/// A hand of the script, with a tremor of `tremor` metres.
inline HandOptions Options(HandScript script, double tremor = 0) {
  HandOptions options;
  options.script = script;
  options.tremor = tremor;
  return options;
}

}  // namespace hpdm
