#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scenes/loader/scene.h"
#include "tools/shared/force_signal.h"

namespace hpdm {

/// One instrument's force on the hand, one sample a haptic tick, N, before the guard.
struct ForceTimeSeries {
  ForceSignal production;      ///< Eq. 29 in the tick, patches of `deformation_hz`.
  ForceSignal reference;       ///< Of the whole model solved at every tick: minus the step's f_c.
  ForceSignal reference_tick;  ///< Eq. 29 in the tick with that step's patch.
  ForceSignal paper;           ///< As production, with rest neighbours (reaction = "paper").
  ForceSignal paper_fitted;    ///< The same with the k1 and k2 that fit the reference best.
  std::vector<double> depth;   ///< m, production's.
  int shaft_ticks = 0;         ///< In which the shaft touched tissue, in the reference.
};

/// Figures of a time series (force_signal.h); errors are over the reference's peak.
struct ForceResults {
  std::string instrument;
  HandScript script = HandScript::kPalpate;
  double peak = 0;             ///< N, the reference's.
  int contact_ticks = 0;       ///< In which the reference acts.
  int missed_ticks = 0;        ///< Of those, in which production does not.
  int false_ticks = 0;         ///< In which production acts and the reference does not.
  int shaft_ticks = 0;         ///< In which the shaft touches tissue.
  double error = 0;            ///< ContactError of production.
  double magnitude_error = 0;  ///< The same of |F| alone.
  double comb = 0;             ///< Comb of production at deformation_hz; NaN: no long contact.
  double largest_step = 0;     ///< N, production's.
  double reference_largest_step = 0;  ///< N.
  double tick_error = 0;              ///< ContactError of reference_tick against reference.
  double largest_tick_error = 0;      ///< Largest difference of the two, over the peak.
  double paper_error = 0;             ///< ContactError of paper, with the scene's k1 and k2,
  double paper_fitted_error = 0;      ///< and of paper_fitted,
  double paper_fitted_k1 = 0;         ///< N/m, with these.
  double paper_fitted_k2 = 0;         ///< N/m.
};

struct ForceAccuracy {
  double rate_hz = 0;
  std::vector<ForceTimeSeries> time_series;  ///< One an instrument.
  std::vector<ForceResults> results;         ///< One an instrument.
  double residual = 0;       ///< Largest relative residual of the reference's steps.
  int unfinished_steps = 0;  ///< Of the reference, that spent their iterations.
};

/// Lets the scene's simulated hands work for `seconds` in lockstep (lockstep.h), records their
/// joints, and plays these to two others: the same loops with a whole deformation step before every
/// tick that sees its patch at once, which is the reference; and production with reaction =
/// "paper". Its springs are fitted, k1 and k2 >= 0, by least squares on all ticks (the force is
/// linear in them but where a press cannot pull). Main thread. Throws InputError as a session does,
/// and when the scene has no instrument.
ForceAccuracy MeasureForceAccuracy(const Scene& scene, double seconds);

}  // namespace hpdm
