#include "tools/haptics/stability_trial.h"

#include <algorithm>
#include <cmath>

namespace hpdm {
namespace {

constexpr double kSmallKick = 1e-6;  // m/s: stays linear
constexpr double kGone = 0.05;       // m

}  // namespace

bool IsStable(const StabilityTrial& trial, StabilityPlant* plant,
              const std::function<void()>& tick) {
  plant->Release(trial.linear ? kSmallKick : trial.kick);
  const double kick_energy = 0.5 * trial.mass * kSmallKick * kSmallKick;
  double energy[4] = {};  // largest in each quarter
  double lowest = 1, highest = -1;
  for (int i = 0; i < trial.ticks; ++i) {
    tick();
    const double e = plant->Energy(trial.stiffness);
    const int quarter = 4 * i / trial.ticks;
    energy[quarter] = std::max(energy[quarter], e);
    if (!std::isfinite(e) || std::abs(plant->x()) > kGone) return false;
    // The motion has grown too far to be linear, so it is unstable.
    if (trial.linear && e > 100 * kick_energy) return false;
    if (quarter == 3) {
      lowest = std::min(lowest, plant->x());
      highest = std::max(highest, plant->x());
    }
  }
  // Energy below round-off counts as decayed.
  const bool decays = energy[3] < std::max(energy[2], 1e-8 * kick_energy);
  return trial.linear ? decays : trial.stiffness * (highest - lowest) < 2 * trial.quiet;
}

StabilityBoundary FindBoundary(double least, double greatest, double growth, double tolerance,
                               const std::function<bool(double)>& is_stable) {
  double low = least, high = least;
  while (is_stable(high)) {
    low = high;
    if (high >= greatest) return {high, true};
    high = std::min(growth * high, greatest);
  }
  if (high == low) low = 0;
  while (high - low > tolerance * high) {
    const double middle = 0.5 * (low + high);
    (is_stable(middle) ? low : high) = middle;
  }
  return {0.5 * (low + high), false};
}

}  // namespace hpdm
