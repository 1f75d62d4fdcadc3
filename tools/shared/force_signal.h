#pragma once

#include <vector>

#include "engine/base/types.h"

/// Figures of a force over time, one sample a haptic tick, N.
namespace hpdm {

using ForceSignal = std::vector<Vector3d>;

/// Largest |F|, N.
double PeakForce(const ForceSignal& force);

/// Root mean square of |force - reference| over the ticks in which one of them is not zero, over
/// the reference's peak. Both of one length. 0 where neither ever acts.
double ContactError(const ForceSignal& force, const ForceSignal& reference);

/// Largest |F(t) - F(t - 1)|, N.
double LargestStep(const ForceSignal& force);

/// The comb that the deformation steps leave in a force: what it has at `comb_hz` and the harmonics
/// up to `rate_hz` / 2 beyond the reference, as root mean square over that of the force. Both of
/// one length, `rate_hz` samples a second.
///
/// Welch's estimate: the reference's stretches of contact are cut into segments of ten periods of
/// comb_hz that overlap by half (a shorter stretch of four periods or more is one segment). With
/// the Hann window w, the segment's power at the harmonic h is that of the sinusoid
///     P_h = 2 |sum_t w_t F_t exp(-2 pi i h comb_hz t / rate_hz)|^2 / (sum_t w_t)^2,
/// summed over the three axes, and its whole power is sum_t w_t^2 |F_t|^2 / sum_t w_t^2. With both
/// averaged over all segments the result is
///     sqrt(sum_h max(0, P_h - P_h of the reference) / power).
/// Ten periods resolve 2 / 10 of comb_hz on either side: the hand's own motion stays out, and a
/// comb that comes and goes with it is still seen. NaN without any segment.
double Comb(const ForceSignal& force, const ForceSignal& reference, double rate_hz, double comb_hz);

}  // namespace hpdm
