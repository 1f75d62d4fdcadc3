#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "engine/threads/histogram.h"

namespace hpdm {

/// Durations that a session records as distributions, by loop, in the order of lcmtypes/stats.lcm.
enum class Latency : std::size_t {
  kHapticWakeUp,       ///< Wake-up minus schedule, over several periods too (WakeUpLateness).
  kHapticCompute,      ///< Wall time of a tick.
  kHapticPeriod,       ///< Time between wake-ups, skipped periods included.
  kPatchAge,           ///< Tick minus the newest device sample in the patch it used.
  kDeviceToForce,      ///< Efforts written minus the device sample they answer, for each tool.
  kDeformationWakeUp,  ///< Wake-up minus schedule.
  kDeformationCompute,
  kDeformationPeriod,  ///< Time between wake-ups.
  kRenderCompute,      ///< Draw, read back, keep.
  kRenderPeriod,       ///< Time between pictures.
  kDeviceToPhoton,     ///< Read-back finished minus the newest device sample shown.
  kBaselineWakeUp,     ///< Empty loop before the session (wake_up_baseline.h).
};
inline constexpr std::size_t kLatencyCount = 12;

/// "loop.quantity": the names in files and messages.
inline constexpr std::array<std::string_view, kLatencyCount> kLatencyNames = {
    "haptic.wake_up",      "haptic.compute",          "haptic.period",
    "haptic.patch_age",    "haptic.device_to_force",  "deformation.wake_up",
    "deformation.compute", "deformation.period",      "render.compute",
    "render.period",       "render.device_to_photon", "baseline.wake_up"};

/// One histogram per Latency. One thread, no allocation.
class Latencies {
 public:
  Histogram& operator[](Latency which) { return histograms_[static_cast<std::size_t>(which)]; }
  const Histogram& operator[](Latency which) const {
    return histograms_[static_cast<std::size_t>(which)];
  }
  /// Calls visit(index, histogram) for each, in the order of Latency.
  template <typename Visit>
  void ForEach(Visit&& visit) const {
    for (std::size_t i = 0; i < kLatencyCount; ++i) visit(i, histograms_[i]);
  }

 private:
  std::array<Histogram, kLatencyCount> histograms_;
};

}  // namespace hpdm
