#pragma once

#include <array>

#include "engine/base/types.h"
#include "haptics/device/hand.h"
#include "haptics/device/hand_script.h"
#include "haptics/device/instrument_options.h"

namespace hpdm {

/// Minimum-jerk movement from 0 to 1 over the normalised time tau in [0, 1]:
/// s = 10 tau^3 - 15 tau^4 + 6 tau^5 (Flash and Hogan 1985). Ends at rest with zero acceleration;
/// its greatest speed is 15/8 = 1.875 times the mean, at tau = 1/2.
struct MinimumJerk {
  static double Position(double tau) { return tau * tau * tau * (10 + tau * (-15 + tau * 6)); }
  /// ds/dtau.
  static double Velocity(double tau) { return 30 * tau * tau * (1 - tau) * (1 - tau); }
};

/// A simulated trainee's hand. It follows a script (hand_script.h) with minimum-jerk movements, has
/// a tremor, and holds the instrument through an impedance, so that the displayed force moves it.
///
/// Tremor: On each world axis there are four sinusoids, one in each 1 Hz band from 8 to 12 Hz.
/// Their frequency and phase are seeded, and their amplitude is tremor / 2. The tremor's root mean
/// square is that of one sinusoid of amplitude `tremor`. The tremor has its own seed, so the script
/// is the same without tremor.
///
/// Deterministic: the same options and site give the same intent at the same times. One thread;
/// wait-free, no allocation after construction.
class SimulatedHand : public Hand {
 public:
  /// Throws InputError if the options or the site make no movement possible.
  SimulatedHand(const HandOptions& options, const HandSite& site);

  std::unique_ptr<Hand> Clone() const override { return std::make_unique<SimulatedHand>(*this); }

  HandIntent At(Nanoseconds t_ns) noexcept override;

 private:
  struct Sinusoid {
    double angular_frequency = 0;  // rad/s
    double phase = 0;              // rad
  };
  static constexpr int kSinusoids = 4;

  void AddTremor(double t, HandIntent* intent) const;

  HandScriptPlan plan_;
  double tremor_;
  std::array<std::array<Sinusoid, kSinusoids>, 3> sinusoids_;
  WayPoint from_;
  WayPoint to_;
  Nanoseconds departed_ns_ = 0;  // when the hand left from_
};

}  // namespace hpdm
