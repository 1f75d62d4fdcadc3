#pragma once

#include <array>
#include <cmath>

#include "engine/organ_options.h"

namespace hpdm {

/// One step of the generalised Maxwell law. Beside a spring K (long-term) stand up to three branches
/// of a spring r_k K and a damper in series:
///     f = K (u + sum_k r_k w_k),   dw_k/dt = du/dt - w_k / tau_k,   r_k = g_k / (1 - sum g)
/// with g_k the terms' shares of the instantaneous modulus. A held step of u relaxes as
///     F(t) = F_0 (1 - sum_k g_k (1 - exp(-t / tau_k))).
/// If u changes linearly during the step from u_0, then exactly
///     w_k' = decay_k w_k + gain_k (u' - u_0),   decay = exp(-dt / tau),   gain = (1 - decay) tau / dt
///     f' = K (stiffening u' + memory),   stiffening = 1 + sum_k r_k gain_k
///     memory = sum_k r_k (decay_k w_k - gain_k u_0).
struct MaxwellStep {
  MaxwellStep() = default;
  /// `dt`: s, >= 0.
  MaxwellStep(const PronySeries& prony, double dt) : count(prony.count) {
    const double long_term = 1 - prony.Share();
    for (int i = 0; i < count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const double elapsed = dt / prony.terms[k].time;
      ratio[k] = prony.terms[k].share / long_term;
      decay[k] = std::exp(-elapsed);
      gain[k] = elapsed > 0 ? -std::expm1(-elapsed) / elapsed : 1;
      stiffening += ratio[k] * gain[k];
    }
  }

  int count = 0;
  std::array<double, PronySeries::kMaxTerms> ratio{};
  std::array<double, PronySeries::kMaxTerms> decay{};
  std::array<double, PronySeries::kMaxTerms> gain{};
  double stiffening = 1;
};

/// The state of such a law: of a point's displacement, a force, or all displacements of an organ.
template <class Value>
struct MaxwellState {
  Value at{};                                            ///< u at the end of the last step.
  std::array<Value, PronySeries::kMaxTerms> branches{};  ///< w_k.

  /// Sets `memory` to that of the next step, with u counted from `origin`.
  void Memory(const MaxwellStep& step, const Value& origin, Value* memory) const {
    *memory = (step.stiffening - 1) * (origin - at);
    for (int i = 0; i < step.count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      *memory += step.ratio[k] * step.decay[k] * branches[k];
    }
  }
  /// Ends a step at `now`.
  void Advance(const MaxwellStep& step, const Value& now) {
    for (int i = 0; i < step.count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      branches[k] = step.decay[k] * branches[k] + step.gain[k] * (now - at);
    }
    at = now;
  }
  /// Sets `sum` to sum_k r_k w_k.
  void Excess(const MaxwellStep& step, Value* sum) const {
    *sum = 0 * at;
    for (int i = 0; i < step.count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      *sum += step.ratio[k] * branches[k];
    }
  }
};

}  // namespace hpdm
