#include "engine/step/strain_blend_controller.h"

#include <algorithm>
#include <cmath>

namespace hpdm {
namespace {

double Towards(double from, double to, double step) {
  return from + std::clamp(to - from, -step, step);
}

}  // namespace

StrainBlendController::StrainBlendController(const OrganOptions& organ)
    : has_finite_(organ.energy.strain != StrainMeasure::kSmall),
      has_refinement_(LocalFunctionsOf(organ) > 0),
      adaptive_(organ.energy.strain == StrainMeasure::kAdaptive),
      finite_from_(organ.energy.finite_from),
      iterations_(organ.energy.newton_iterations) {
  last_.finite_strain_blend = has_finite_ && !adaptive_ ? 1 : 0;
  last_.refinement_weight = has_refinement_ ? 1 : 0;
}

double StrainBlendController::WantedBlend(const QualityCeiling& ceiling, bool touched,
                                          double gradient) {
  if (!has_finite_) return 0;
  if (adaptive_) {
    const double bound = wants_finite_ ? kBack * finite_from_ : finite_from_;
    wants_finite_ = touched && gradient > bound;
  }
  return ceiling.finite && (wants_finite_ || !adaptive_) ? 1 : 0;
}

// Returns the largest change of the share of finite strain in a step.
double StrainBlendController::LargestStep(double gradient, double share_slope) const {
  const bool blended = last_.finite_strain_blend > 0 && last_.finite_strain_blend < 1;
  if (!blended) return kFirstStep;
  const double beyond = adaptive_ ? std::max(1.0, gradient / finite_from_) : 1;
  const double force_step = std::min(kMaxForceStep, kForceStep * beyond);
  const double by_share = kForceOverEnergy * std::abs(share_slope);
  return by_share * kMaxBlendStep > force_step ? force_step / by_share : kMaxBlendStep;
}

StepQuality StrainBlendController::Next(const QualityCeiling& ceiling, bool touched,
                                        double gradient, double share_slope) {
  const double finite = WantedBlend(ceiling, touched, gradient);
  const double refinement = has_refinement_ && ceiling.refinement ? 1 : 0;
  StepQuality next;
  next.newton_iterations = std::max(1, iterations_ >> std::min(ceiling.halvings, 30));
  next.finite_strain_blend =
      touched ? Towards(last_.finite_strain_blend, finite, LargestStep(gradient, share_slope))
              : finite;
  next.refinement_weight =
      touched ? Towards(last_.refinement_weight, refinement, kRefinementStep) : refinement;
  settled_ =
      (ceiling.finite || next.finite_strain_blend == 0) && next.refinement_weight == refinement;
  last_ = next;
  return next;
}

}  // namespace hpdm
