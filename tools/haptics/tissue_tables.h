#pragma once

#include <functional>
#include <vector>

#include "tools/haptics/contact_tables.h"
#include "tools/haptics/tissue_trials.h"

/// Tables of viscoelastic tissue: the felt force against the law, and the energy that a hand is
/// given.
namespace hpdm {

inline constexpr double kTissueForceError = 0.02;  ///< Of the law's amplitude.
inline constexpr double kTissuePhaseError = 2;     ///< Degrees.

/// Errors of a press by a step within one tick, and by a ramp, both then held.
struct HoldError {
  double step = 0;  ///< Largest over all ticks of the hold, of the law's force.
  double ramp = 0;  ///< Largest during the ramp, of the law's largest force.
  double hold = 0;  ///< Largest after the ramp, of the law's force.
};
/// Compares 4 mm deep presses with the law of `law`, which is press.prony unless a judgement is
/// checked.
HoldError MeasureHold(const TissuePress& press, const RelaxedPress& relaxed,
                      const PronySeries& law);

/// A sine of 0.2 mm about a depth of 4 mm: felt over the law's.
struct SineError {
  double ratio = 0;  ///< Of the amplitudes.
  double phase = 0;  ///< Degrees; negative: the force is late.
};
SineError MeasureSine(const TissuePress& press, const RelaxedPress& relaxed, const PronySeries& law,
                      double frequency);

/// Measures all; `done` gets each table as soon as it is measured. `quick`: fewer cases.
std::vector<ContactTable> MeasureTissue(bool quick,
                                        const std::function<void(const ContactTable&)>& done);

}  // namespace hpdm
