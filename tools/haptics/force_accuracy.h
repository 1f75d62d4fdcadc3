#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scenes/loader/scene.h"
#include "tools/shared/force_signal.h"

namespace hpdm {

/// Force of one instrument on the hand, N, before the guard, one sample a haptic tick.
struct ForceTimeSeries {
  ForceSignal production;      ///< Eq. 29 in the tick, with patches at `deformation_hz`.
  ForceSignal reference;       ///< The whole model solved at every tick: minus the step's f_c.
  ForceSignal reference_tick;  ///< Eq. 29 in the tick, with the reference step's patch.
  ForceSignal paper;           ///< As production, with neighbours at rest (reaction = "paper").
  ForceSignal paper_fitted;    ///< The same with k1 and k2 fitted to the reference.
  ForceSignal independent;  ///< One every `judged_every` ticks: the reaction of the contact that a
                            ///< dense search finds (contact_reference.h).
  std::vector<double> depth;  ///< m, of production.
  int shaft_ticks = 0;        ///< Ticks in which the shaft touched tissue, in the reference.

  std::size_t judged_every = 1;  ///< Ticks.
};

/// Measures of a time series (force_signal.h). Errors are relative to the reference's peak.
struct ForceResults {
  std::string instrument;
  HandScript script = HandScript::kPalpate;
  double independent_error = 0;  ///< ContactError of production against `independent`: the judged
                                 ///< error. It does not share the place of the contact.
  int independent_ticks = 0;     ///< Judged ticks in which `independent` acts.
  int independent_missed = 0;    ///< Those in which production does not act.
  int independent_false = 0;     ///< Judged ticks in which only production acts.
  double peak = 0;               ///< N, of the reference.
  int contact_ticks = 0;         ///< Ticks in which the reference acts.
  int missed_ticks = 0;          ///< Contact ticks in which production does not act.
  int false_ticks = 0;           ///< Ticks in which only production acts.
  int shaft_ticks = 0;           ///< Ticks in which the shaft touches tissue.
  double error = 0;              ///< ContactError of production against the reference, whose places
                                 ///< come from its own ticks.
  double magnitude_error = 0;    ///< ContactError of |F| alone.
  double comb = 0;               ///< Comb of production at deformation_hz; NaN: no long contact.
  double largest_step = 0;       ///< N, of production.
  double reference_largest_step = 0;  ///< N.
  double tick_error = 0;              ///< ContactError of reference_tick against reference.
  double largest_tick_error = 0;      ///< Largest difference of the two, relative to the peak.
  double paper_error = 0;             ///< ContactError of paper, with the scene's k1 and k2.
  double paper_fitted_error = 0;      ///< ContactError of paper_fitted.
  double paper_fitted_k1 = 0;         ///< N/m, fitted.
  double paper_fitted_k2 = 0;         ///< N/m, fitted.
};

struct ForceAccuracy {
  double rate_hz = 0;
  std::vector<ForceTimeSeries> time_series;  ///< One per instrument.
  std::vector<ForceResults> results;         ///< One per instrument.
  double residual = 0;       ///< Largest relative residual of the reference's steps.
  int unsolved = 0;          ///< Searches of the independent reference without a sound place.
  int unfinished_steps = 0;  ///< Reference steps that used all their iterations.
};

/// Measures the force accuracy of a scene. Main thread.
/// 1. Lets the scene's simulated hands work for `seconds` in lockstep (lockstep.h) and records
///    their joints.
/// 2. Plays the joints to the reference: the same loops with a whole deformation step before every
///    tick, which uses its patch at once.
/// 3. Solves the organs every 20 ms (finite strain: 100 ms) and searches the contacts densely
///    (contact_reference.h). Neither place nor normal comes from a tick.
/// 4. Plays them to production with reaction = "paper". Its k1 and k2 >= 0 are fitted by least
///    squares on all ticks; the force is linear in them except where a press cannot pull.
///
/// Throws InputError as a session does, and if the scene has no instrument.
ForceAccuracy MeasureForceAccuracy(const Scene& scene, double seconds);

}  // namespace hpdm
