#include "engine/step/load_shedding.h"

#include <algorithm>

#include "engine/solver/elastic_relaxation.h"

namespace hpdm {

Sheddable SheddableOf(const std::vector<OrganOptions>& organs) {
  Sheddable sheddable;
  for (const OrganOptions& organ : organs) {
    sheddable.refinement = sheddable.refinement || LocalFunctionsOf(organ) > 0;
    if (organ.energy.strain == StrainMeasure::kSmall) continue;
    sheddable.finite = true;
    sheddable.newton_iterations =
        std::max(sheddable.newton_iterations, organ.energy.newton_iterations);
  }
  return sheddable;
}

LoadShedding::LoadShedding(const Sheddable& sheddable, Nanoseconds budget)
    : budget_(budget), finite_(sheddable.finite), refinement_(sheddable.refinement) {
  while (sheddable.newton_iterations >> halvings_ > kLeastNewtonIterations) ++halvings_;
}

QualityCeiling LoadShedding::Ceiling() const {
  const int beyond = level_ - halvings_;
  return {.halvings = std::min(level_, halvings_),
          .finite = !finite_ || beyond < 1,
          .refinement = !refinement_ || beyond < (finite_ ? 2 : 1)};
}

void LoadShedding::Observe(Nanoseconds now_ns, Nanoseconds compute_ns, bool settled) {
  if (budget_ <= 0) return;
  const bool too_long = compute_ns > budget_;
  too_long_ = too_long ? too_long_ + 1 : 0;
  if (too_long_ >= kTooMany && settled && level_ < levels()) Lower(now_ns);
  const bool easy = level_ > 0 && settled && compute_ns < static_cast<Nanoseconds>(kEase * budget_);
  if (!easy) {
    easy_since_ns_ = -1;
  } else if (easy_since_ns_ < 0) {
    easy_since_ns_ = now_ns;
  } else if (now_ns - easy_since_ns_ >= wait_ns_) {
    Raise(now_ns);
  }
}

void LoadShedding::Lower(Nanoseconds now_ns) {
  const bool again = raised_ns_ >= 0 && now_ns - raised_ns_ < wait_ns_;
  wait_ns_ = again ? std::min(2 * wait_ns_, kMaxWait) : kWait;
  ++level_;
  too_long_ = 0;
}

void LoadShedding::Raise(Nanoseconds now_ns) {
  --level_;
  raised_ns_ = now_ns;
  easy_since_ns_ = -1;
}

}  // namespace hpdm
