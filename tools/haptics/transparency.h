#pragma once

#include <string>
#include <vector>

#include "tools/haptics/contact_loop.h"
#include "tools/haptics/contact_tables.h"

namespace hpdm {

/// Force that a hand feels from one contact at one frequency, over the force of the model.
struct TransparencyPoint {
  double hertz = 0;
  double amplitude = 0;  ///< m, of the tip.
  double rendered = 0;   ///< |force / motion|, N/m.
  double ratio = 0;      ///< Rendered over model, |.|.
  double phase = 0;      ///< Of rendered over model, degrees; negative: late.
};

/// A contact's transparency under one set of conditions.
struct Transparency {
  std::string contact;
  DisplayConditions display = {};
  double model = 0;  ///< N/m: slope of the model's force in the middle of the motion.
  std::vector<TransparencyPoint> points;
};

/// The static force of the whole model against the depth of a tip, from the solved organs without
/// the tick (contact_reference.h). A cubic polynomial, fitted at nine depths of a tip that has been to
/// the deepest one and back: with friction a first press slips where a motion to and fro sticks.
class ModelForce {
 public:
  /// Depths from `least` to `most` (m along the guide).
  ModelForce(const ShippedContact& contact, double least, double most);
  double At(double x) const;       ///< N.
  double SlopeAt(double x) const;  ///< N/m.

 private:
  double middle_, half_;
  Eigen::Vector4d coefficients_;
};

/// Measures the transparency of a contact under each of the conditions. The session's own loops run in lockstep with the plant in
/// the simulated hand, which holds the contact at its reference pose and moves its intent to and fro
/// along the guide, so that the tip moves by about a quarter of the depth. At each frequency, after
/// half a second, over whole periods (at least 0.5 s):
///
///     F = fundamental of the displayed force, held from tick to tick,
///     G = fundamental of ModelForce at the tip's true motion,   ratio = F / G.
///
/// So the ratio contains encoders, rate, delay, the hand-over of patches, the passivity controller
/// and the guard. Deterministic.
std::vector<Transparency> MeasureTransparency(const ShippedContact& contact,
                                              const std::vector<DisplayConditions>& displays,
                                              const std::vector<double>& frequencies);

/// Returns the conditions in which a contact is measured: the scene's, and the same without the
/// passivity controller and the guard's limits.
std::vector<DisplayConditions> TransparencyConditions(const ShippedContact& contact);
/// Returns 0.1 to 20 Hz; `quick`: two of them.
std::vector<double> TransparencyFrequencies(bool quick);

/// Returns the tables of ratio and phase, one column a frequency. All have the same frequencies.
std::vector<ContactTable> TransparencyTables(const std::vector<Transparency>& measured);

/// Writes a line for each point with the columns contact, rate_hz, delay_s, control, guard,
/// model_N_per_m, frequency_Hz, amplitude_m, rendered_N_per_m, ratio, phase_degrees. Throws
/// InputError.
void WriteTransparencyCsv(const std::vector<Transparency>& measured, const std::string& path);

}  // namespace hpdm
