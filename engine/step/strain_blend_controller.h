#pragma once

#include "engine/organ_options.h"
#include "engine/solver/step_quality.h"

namespace hpdm {

/// Upper bound on the quality of all organs, set by the time budget (load_shedding.h).
struct QualityCeiling {
  int halvings = 0;  ///< Halvings of Newton's iterations; one iteration always remains.
  bool finite = true;
  bool refinement = true;
};

/// Chooses one organ's quality in each step from its state and a ceiling. Changes are gradual, so
/// that the hand does not feel them.
///
/// Adaptive strain begins as small strain. It moves to finite strain when |grad u|
/// (InversionDetector::LargestGradient) exceeds `finite_from`, and back below kBack times that. In
/// between, the energy is a blend of both (blended_energy.h) with the share s of finite strain:
///
/// 1. s moves so far in a step that the force changes by about the fraction kForceStep. If |grad u|
///    is a multiple of the bound, the fraction is that multiple of kForceStep, at most
///    kMaxForceStep. So the model keeps up with a fast tool.
/// 2. Held contacts do no work, so the energy E changes by (dE/ds) ds.
/// 3. The two energies differ at O(depth^3) and E is O(depth^2), so the force changes by about the
///    fraction kForceOverEnergy dE / E.
/// 4. A blend can be slightly stiffer than both ends, since small strain resists rotation.
///    Therefore s does not stay in between.
///
/// Ceilings and the weight of the local functions are followed gradually too. Without contact there
/// is no force, and changes are immediate. Decisions depend on the states alone; one thread;
/// allocates nothing.
class StrainBlendController {
 public:
  static constexpr double kBack = 0.8;
  static constexpr double kForceStep = 0.005;
  static constexpr double kMaxForceStep = 0.02;
  static constexpr double kForceOverEnergy = 3;
  static constexpr double kFirstStep = 1.0 / 256;  ///< From one strain alone: dE/ds is unknown.
  static constexpr double kMaxBlendStep = 1.0 / 8;
  static constexpr double kRefinementStep = 1.0 / 32;

  explicit StrainBlendController(const OrganOptions& organ);

  /// Returns the next step's quality. `touched`, `gradient` (|grad u|) and `share_slope`
  /// (RelaxationResult::share_slope) are those of the last step.
  StepQuality Next(const QualityCeiling& ceiling, bool touched, double gradient,
                   double share_slope);
  /// Sets the recorded quality; a replay calls it after Next.
  void ApplyRecorded(const StepQuality& quality) { last_ = quality; }

  /// True if the last Next() reached the quality that the ceiling and the state ask for.
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
