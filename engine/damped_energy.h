#pragma once

#include <memory>

#include "engine/elastic_energy.h"

namespace hpdm {

/// An elastic energy and a damper,
///     E(U) + damping / 2 (U - from)^T K (U - from),   K the stiffness at rest
/// (viscous_recovery.h).
class DampedEnergy final : public ElasticEnergy {
 public:
  explicit DampedEnergy(std::unique_ptr<ElasticEnergy> elastic);
  std::unique_ptr<ElasticEnergy> Clone() const override;

  /// `damping`: 0 for none. No allocation.
  void Damp(double damping, const Points& from);
  double damping() const { return damping_; }
  const FullStiffness& stiffness_at_rest() const { return K_; }  ///< 3n x 3n, N/m.

  int control_points() const override { return elastic_->control_points(); }
  double Energy(const Points& U) override;
  double Gradient(const Points& U, Points* gradient) override;
  void Hessian(const Points& U, bool semi_definite, FullStiffness* K) override;
  double CollapsedShare(const Points& U) override { return elastic_->CollapsedShare(U); }

 private:
  double Pull(const Points& U);

  std::unique_ptr<ElasticEnergy> elastic_;
  FullStiffness K_;
  double damping_ = 0;
  Points from_;  // n x 3, m
  Points away_;  // n x 3, m: U - from
  Points pull_;  // n x 3, N
};

}  // namespace hpdm
