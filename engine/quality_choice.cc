#include "engine/quality_choice.h"

#include <algorithm>
#include <cmath>

namespace hpdm {
namespace {

double Towards(double from, double to, double step) {
  return from + std::clamp(to - from, -step, step);
}

}  // namespace

QualityChoice::QualityChoice(const OrganOptions& organ)
    : has_finite_(organ.energy.strain != StrainMeasure::kSmall),
      has_local_(LocalFunctionsOf(organ) > 0),
      adaptive_(organ.energy.strain == StrainMeasure::kAdaptive),
      finite_from_(organ.energy.finite_from),
      iterations_(organ.energy.newton_iterations) {
  last_.finite_share = has_finite_ && !adaptive_ ? 1 : 0;
  last_.local_share = has_local_ ? 1 : 0;
}

double QualityChoice::WantedShare(const QualityCeiling& ceiling, bool touched, double gradient) {
  if (!has_finite_) return 0;
  if (adaptive_) {
    const double bound = wants_finite_ ? kBack * finite_from_ : finite_from_;
    wants_finite_ = touched && gradient > bound;
  }
  return ceiling.finite && (wants_finite_ || !adaptive_) ? 1 : 0;
}

// Of the share of finite strain.
double QualityChoice::LargestStep(double gradient, double share_slope) const {
  if (last_.finite_share == 0) return kFirstStep;
  const double beyond = adaptive_ ? std::max(1.0, gradient / finite_from_) : 1;
  const double force_step = std::min(kMostForceStep, kForceStep * beyond);
  const double by_share = kForceOverEnergy * std::abs(share_slope);
  return by_share * kLargestStep > force_step ? force_step / by_share : kLargestStep;
}

OrganQuality QualityChoice::Next(const QualityCeiling& ceiling, bool touched, double gradient,
                                 double share_slope) {
  const double finite = WantedShare(ceiling, touched, gradient);
  const double local = has_local_ && ceiling.local ? 1 : 0;
  OrganQuality next;
  next.newton_iterations = std::max(1, iterations_ >> std::min(ceiling.halvings, 30));
  next.finite_share =
      touched ? Towards(last_.finite_share, finite, LargestStep(gradient, share_slope)) : finite;
  next.local_share = touched ? Towards(last_.local_share, local, kLocalStep) : local;
  settled_ = (ceiling.finite || next.finite_share == 0) && next.local_share == local;
  last_ = next;
  return next;
}

}  // namespace hpdm
