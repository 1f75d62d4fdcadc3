#include "engine/energy/blended_energy.h"

#include <utility>

#include "engine/energy/strain_energy.h"

namespace hpdm {

BlendedEnergy::BlendedEnergy(std::unique_ptr<ElasticEnergy> finite,
                             const ScalarStiffness* elastic_supports)
    : finite_(std::move(finite)),
      from_(Points::Zero(finite_->control_points(), 3)),
      away_(from_),
      pull_(from_) {
  finite_->Hessian(from_, false, &K_);
  if (elastic_supports == nullptr) return;
  K_t_ = K_;
  AddAlongEachAxis(ScalarStiffness(-*elastic_supports), &K_t_);
}

void BlendedEnergy::Damp(double damping, const Points& from) {
  damping_ = damping;
  from_ = from;
}

// Fills pull_ with the force of springs `stiffness` K and returns their energy.
double BlendedEnergy::Pull(double stiffness, const FullStiffness& K, const Points& away) {
  const Eigen::Map<const Eigen::VectorXd> moved(away.data(), away.size());
  Eigen::Map<Eigen::VectorXd> pull(pull_.data(), pull_.size());
  pull.noalias() = stiffness * (K * moved);
  return pull.dot(moved) / 2;
}

double BlendedEnergy::Energy(const Points& U) {
  double energy = share_ > 0 ? finite_->Energy(U) : 0;
  if (share_ < 1) energy = share_ * energy + Pull(1 - share_, K_, U);
  if (damping_ > 0) {
    away_ = U - from_;
    energy += Pull(damping_, damper(), away_);
  }
  return energy;
}

double BlendedEnergy::Gradient(const Points& U, Points* gradient) {
  finite_energy_ = finite_->Gradient(U, gradient);
  double energy = finite_energy_;
  if (share_ < 1) {
    energy = share_ * energy + Pull(1 - share_, K_, U);
    *gradient = share_ * *gradient + pull_;
  }
  if (damping_ > 0) {
    away_ = U - from_;
    energy += Pull(damping_, damper(), away_);
    *gradient += pull_;
  }
  return energy;
}

void BlendedEnergy::Hessian(const Points& U, bool semi_definite, FullStiffness* K) {
  finite_->Hessian(U, semi_definite, K);
  if (share_ < 1) *K = share_ * *K + (1 - share_) * K_;
  if (damping_ > 0) *K += damping_ * damper();
}

double BlendedEnergy::ShareSlope(const Points& U) {
  const double small_energy = Pull(1, K_, U);
  const double energy = share_ * finite_energy_ + (1 - share_) * small_energy;
  return energy > 0 ? (finite_energy_ - small_energy) / energy : 0;
}

}  // namespace hpdm
