#include "engine/quality_choice.h"

#include <algorithm>
#include <cmath>

namespace hpdm {
namespace {

double Towards(double from, double to, double step) {
  return from + std::clamp(to - from, -step, step);
}

}  // namespace

QualityChoice::QualityChoice(const OrganModel& model)
    : has_finite_(model.finite_energy() != nullptr),
      has_local_(model.local() != nullptr),
      adaptive_(model.options().energy.strain == StrainMeasure::kAdaptive),
      finite_from_(model.options().energy.finite_from),
      iterations_(model.options().energy.newton_iterations) {
  last_.finite_share = has_finite_ && !adaptive_ ? 1 : 0;
  last_.local_share = has_local_ ? 1 : 0;
}

double QualityChoice::NeededShare(double gradient) const {
  const double along =
      std::clamp((gradient / finite_from_ - 1) / (kWhole - 1), 0.0, 1.0);
  return along * along * (3 - 2 * along);
}

OrganQuality QualityChoice::Next(const QualityCeiling& ceiling, bool touched, double gradient,
                                 double share_slope) {
  double finite = has_finite_ && ceiling.finite ? 1 : 0;
  if (adaptive_ && finite > 0) {
    finite = touched ? std::clamp(last_.finite_share, NeededShare(gradient),
                                  NeededShare(gradient / (1 - kSlack)))
                     : 0;
  }
  const double local = has_local_ && ceiling.local ? 1 : 0;
  OrganQuality next;
  next.newton_iterations = std::max(1, iterations_ >> std::min(ceiling.halvings, 30));
  next.finite_share = finite;
  next.local_share = local;
  if (touched) {
    const double most = last_.finite_share == 0 ? kFirstStep
                        : share_slope == 0      ? kLargestStep
                                                : std::min(kLargestStep, kForceStep / kForceOverEnergy /
                                                                        std::abs(share_slope));
    next.finite_share = Towards(last_.finite_share, finite, most);
    next.local_share = Towards(last_.local_share, local, kLocalStep);
  }
  // The state's own wish is not waited for: it may change as long as the tool moves.
  settled_ = (finite > 0 || next.finite_share == 0) && next.local_share == local;
  last_ = next;
  return next;
}

}  // namespace hpdm
