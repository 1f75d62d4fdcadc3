#pragma once

#include "engine/organ_options.h"
#include "engine/solver/step_quality.h"

namespace hpdm {

/// What the time allows all organs (load_shedding.h).
struct QualityCeiling {
  int halvings = 0;  ///< Of Newton's iterations; one always remains.
  bool finite = true;
  bool refinement = true;
};

/// Chooses one organ's quality step by step: what its state needs, under a ceiling, in steps that
/// no hand feels.
///
/// Adaptive strain begins in small strain, and goes to finite strain when |grad u|
/// (InversionDetector::LargestGradient) exceeds `finite_from`, and back below kBack times that. On
/// the way the energy is a blend of both (blended_energy.h), whose shares move only so far in a
/// step that the force changes by about kForceStep of itself; up to kMaxForceStep where the tissue
/// is as many times beyond the bound, so that a fast tool does not leave the model behind. An
/// energy E changes by (dE/ds) / E ds where the contacts hold the tissue and do no work, and the
/// force, its derivative by the depth, by kForceOverEnergy times as much of itself: both strains
/// agree to second order, so what is between them is of third order and more in the depth, and E of
/// second. Ceilings and what the local functions do are followed in the same way. Without contact
/// there is no force, and nothing to be gradual about.
///
/// A blend may be a little stiffer than both (small strain resists rotation), which is why it is
/// gone through and not stayed in.
///
/// Follows from the states alone; one thread; allocates nothing.
class StrainBlendController {
 public:
  static constexpr double kBack = 0.8;
  static constexpr double kForceStep = 0.005;
  static constexpr double kMaxForceStep = 0.02;
  static constexpr double kForceOverEnergy = 3;
  static constexpr double kFirstStep = 1.0 / 256;  ///< From small strain, where dE/ds is unknown.
  static constexpr double kMaxBlendStep = 1.0 / 8;
  static constexpr double kRefinementStep = 1.0 / 32;

  explicit StrainBlendController(const OrganOptions& organ);

  /// For the next step. Of the last one: whether the organ was touched, |grad u|, and
  /// RelaxationResult::share_slope.
  StepQuality Next(const QualityCeiling& ceiling, bool touched, double gradient,
                   double share_slope);
  /// What a replay takes in its place.
  void ApplyRecorded(const StepQuality& quality) { last_ = quality; }

  /// Whether the last Next() is where the ceiling and the state want it.
  bool settled() const { return settled_; }

 private:
  double WantedBlend(const QualityCeiling& ceiling, bool touched, double gradient);
  double LargestStep(double gradient, double share_slope) const;

  bool has_finite_;
  bool has_refinement_;
  bool adaptive_;
  double finite_from_;
  int iterations_;
  bool wants_finite_ = false;  // adaptive
  StepQuality last_;
  bool settled_ = true;
};

}  // namespace hpdm
