#include "engine/damped_energy.h"

#include <utility>

namespace hpdm {

DampedEnergy::DampedEnergy(std::unique_ptr<ElasticEnergy> elastic)
    : elastic_(std::move(elastic)),
      K_(3 * elastic_->control_points(), 3 * elastic_->control_points()),
      from_(Points::Zero(elastic_->control_points(), 3)),
      away_(from_),
      pull_(from_) {
  elastic_->Hessian(from_, false, &K_);
}

std::unique_ptr<ElasticEnergy> DampedEnergy::Clone() const {
  auto clone = std::make_unique<DampedEnergy>(elastic_->Clone());
  clone->Damp(damping_, from_);
  return clone;
}

void DampedEnergy::Damp(double damping, const Points& from) {
  damping_ = damping;
  from_ = from;
}

// Fills pull_ and returns the damper's energy.
double DampedEnergy::Pull(const Points& U) {
  away_ = U - from_;
  const Eigen::Map<const Eigen::VectorXd> away(away_.data(), away_.size());
  Eigen::Map<Eigen::VectorXd> pull(pull_.data(), pull_.size());
  pull.noalias() = damping_ * (K_ * away);
  return pull.dot(away) / 2;
}

double DampedEnergy::Energy(const Points& U) {
  return elastic_->Energy(U) + (damping_ > 0 ? Pull(U) : 0);
}

double DampedEnergy::Gradient(const Points& U, Points* gradient) {
  const double elastic = elastic_->Gradient(U, gradient);
  if (!(damping_ > 0)) return elastic;
  const double damper = Pull(U);
  *gradient += pull_;
  return elastic + damper;
}

void DampedEnergy::Hessian(const Points& U, bool semi_definite, FullStiffness* K) {
  elastic_->Hessian(U, semi_definite, K);
  if (damping_ > 0) *K += damping_ * K_;
}

}  // namespace hpdm
