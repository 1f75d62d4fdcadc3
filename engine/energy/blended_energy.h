#pragma once

#include <memory>

#include "engine/base/copying.h"
#include "engine/energy/elastic_energy.h"
#include "engine/energy/metric_energy.h"

namespace hpdm {

/// The energy that a deformation step minimises: finite strain with the share s, small strain with
/// the share 1 - s, and the branches of viscoelastic tissue (maxwell_memory.h),
///     E(U) = s E_finite(U) + (1 - s)/2 U^T K U + damping/2 (U - from)^T K_t (U - from),
///     K = d^2 E_finite / dU^2 at rest,   K_t: K without elastic supports.
/// The two strains agree to second order in U, so E is smooth in s.
class BlendedEnergy final : public ElasticEnergy {
 public:
  /// Starts with s = 1 and no damper.
  /// `elastic_supports`: springs of the energy (n x n, N/m, the same along each axis) that the
  /// damper does not have; nullptr: none.
  explicit BlendedEnergy(std::unique_ptr<ElasticEnergy> finite,
                         const ScalarStiffness* elastic_supports = nullptr);
  std::unique_ptr<ElasticEnergy> Clone() const override {
    return std::make_unique<BlendedEnergy>(*this);
  }

  /// Sets s, 0..1.
  void SetShare(double share) { share_ = share; }
  double share() const { return share_; }
  /// Sets the damper: its weight `damping` (0: none) and the displacements `from` (n x 3, m) at
  /// which it exerts no force. No allocation.
  void Damp(double damping, const Points& from);
  double damping() const { return damping_; }
  const FullStiffness& stiffness_at_rest() const { return K_; }  ///< 3n x 3n, N/m.

  /// Returns (E_finite - E_small) / E at U without the damper; 0 if E is 0. This is dE/ds over E
  /// under contacts, which do no work when s changes. Requires that the last Gradient() was at U.
  double ShareSlope(const Points& U);

  int control_points() const override { return finite_->control_points(); }
  double Energy(const Points& U) override;
  double Gradient(const Points& U, Points* gradient) override;
  void Hessian(const Points& U, bool semi_definite, FullStiffness* K) override;
  double CollapsedShare(const Points& U) override { return finite_->CollapsedShare(U); }

 private:
  double Pull(double stiffness, const FullStiffness& K, const Points& away);
  const FullStiffness& damper() const { return K_t_.size() > 0 ? K_t_ : K_; }

  Cloned<ElasticEnergy> finite_;
  FullStiffness K_;
  FullStiffness K_t_;  // empty: K
  double share_ = 1;
  double damping_ = 0;
  double finite_energy_ = 0;  // J, E_finite at the last Gradient()
  Points from_;               // n x 3, m
  Points away_;               // n x 3, m: U - from
  Points pull_;               // n x 3, N
};

}  // namespace hpdm
