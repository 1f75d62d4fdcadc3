#include "engine/energy/blended_energy.h"

#include <utility>

#include "engine/energy/strain_energy.h"

namespace hpdm {

BlendedEnergy::BlendedEnergy(std::unique_ptr<ElasticEnergy> finite, FullStiffness K,
                             const ScalarStiffness* elastic_supports,
                             const SchurComplement* functions, int slots)
    : finite_(std::move(finite)),
      K_(std::move(K)),
      functions_(functions),
      from_(Points::Zero(finite_->control_points() + slots, 3)),
      away_(from_),
      pull_(from_),
      lattice_(K_.rows()) {
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
  const Eigen::Index unknowns = K_.rows(), own = moved.size() - unknowns;
  lattice_ = moved.head(unknowns);
  if (functions_ != nullptr) functions_->AddCoupling(1, moved.tail(own), lattice_);
  pull.head(unknowns).noalias() = stiffness * (K * lattice_);
  if (functions_ != nullptr) {
    pull.tail(own).noalias() = -stiffness * (functions_->stiffness() * moved.tail(own));
    functions_->Reduce(pull.head(unknowns), pull.tail(own));
    pull.tail(own) *= -1;
  }
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

// Without local functions.
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
