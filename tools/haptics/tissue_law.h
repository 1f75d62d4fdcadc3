#pragma once

#include <vector>

#include "engine/organ_options.h"

/// The generalised Maxwell law by its convolution integral, to judge the law of step and tick by. It
/// shares no formula with engine/energy/maxwell_law.h, which integrates a state from step to step.
namespace hpdm {

/// Returns the force (N) of tissue in a contact that grows or is held, from the force `elastic` (N)
/// that relaxed tissue has in the same positions, at samples `period` (s) apart:
///     F(t) = int (1 + sum_k r_k exp(-(t - s) / tau_k)) dF_e(s),   r_k = g_k / (1 - sum g).
/// F_e is linear between two samples, the kernel is integrated by Simpson's rule. The tissue is at
/// rest before the first sample.
std::vector<double> RelaxedForce(const PronySeries& prony, const std::vector<double>& elastic,
                                 double period);

/// A sine in a signal.
struct Fundamental {
  double amplitude = 0;
  double phase = 0;  ///< rad, ahead of sin(2 pi frequency t) with t = 0 at the first sample.
};
/// Fits a sine of `frequency` (Hz) and a quadratic drift to the last `count` samples.
Fundamental FundamentalOf(const std::vector<double>& signal, std::size_t count, double frequency,
                          double period);

}  // namespace hpdm
