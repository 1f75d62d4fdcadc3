#pragma once

#include <vector>

#include "engine/base/types.h"

/// Measures of a force signal, one sample a haptic tick, N.
namespace hpdm {

using ForceSignal = std::vector<Vector3d>;

/// Returns the largest |F|, N.
double PeakForce(const ForceSignal& force);

/// Returns the RMS of |force - reference| over the ticks in which either is not zero, divided by
/// the reference's peak. Both signals have one length. Returns 0 if neither ever acts.
double ContactError(const ForceSignal& force, const ForceSignal& reference);

/// Returns the largest |F(t) - F(t - 1)|, N.
double LargestStep(const ForceSignal& force);

/// Returns the comb that the deformation steps leave in a force, relative to the RMS of the force.
/// The comb is the power at `comb_hz` and its harmonics up to `rate_hz` / 2 that the reference does
/// not have. Both signals have one length and `rate_hz` samples a second.
///
/// It is Welch's estimate:
/// 1. The reference's contacts are cut into segments of ten periods of comb_hz that overlap by
///     half. A contact of four to ten periods is one segment.
/// 1. The reference's contacts are cut into segments of ten periods of comb_hz that overlap by
///    half. A contact of four to ten periods is one segment.
///    summed over the three axes. Its total power is sum_t w_t^2 |F_t|^2 / sum_t w_t^2.
/// 3. With both averaged over all segments, the result is
///        sqrt(sum_h max(0, P_h - P_h of the reference) / power).
///
/// Ten periods resolve 2 / 10 of comb_hz on either side. That excludes the hand's own motion and
/// keeps a comb that varies with it. NaN without any segment.
double Comb(const ForceSignal& force, const ForceSignal& reference, double rate_hz, double comb_hz);

}  // namespace hpdm
