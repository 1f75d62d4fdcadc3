#pragma once

#include <memory>

#include "engine/base/copying.h"
#include "engine/energy/elastic_energy.h"
#include "engine/energy/metric_energy.h"
#include "engine/solver/schur_complement.h"

namespace hpdm {

/// The energy that a deformation step minimises: finite strain with the share s, small strain with
/// the share 1 - s, and the branches of viscoelastic tissue (maxwell_memory.h),
///     E(U) = s E_finite(U) + (1 - s)/2 U^T K U + damping/2 (U - from)^T K_t (U - from),
/// with K the stiffness of small strain and K_t that without elastic supports. The two strains agree
/// to second order in U, so E is smooth in s. Local functions in use follow U's rows
/// (ElasticEnergy::SetActiveFunctions).
class BlendedEnergy final : public ElasticEnergy {
 public:
  /// Starts with s = 1 and no damper. `K`: 3n x 3n, N/m. `functions` and `slots`: of the local
  /// functions, or none; `functions` must outlive the energy. `elastic_supports`: springs of the
  /// energy (n x n, N/m, the same along each axis) that the damper does not have; nullptr: none.
  BlendedEnergy(std::unique_ptr<ElasticEnergy> finite, FullStiffness K,
                const ScalarStiffness* elastic_supports = nullptr,
                const SchurComplement* functions = nullptr, int slots = 0);
  /// The copy refers to the same `functions` until Rebind().
  std::unique_ptr<ElasticEnergy> Clone() const override {
    return std::make_unique<BlendedEnergy>(*this);
  }
  void Take(const ElasticEnergy& other) override {
    *this = static_cast<const BlendedEnergy&>(other);
  }
  void Rebind(const SchurComplement* functions) { functions_ = functions; }
  void SetActiveFunctions(const ActiveRefinement& active) override {
    finite_->SetActiveFunctions(active);
  }

  /// Sets s, 0..1.
  void SetShare(double share) { share_ = share; }
  double share() const { return share_; }
  /// Sets the damper: its weight `damping` (0: none) and the displacements `from` (n x 3, m) at
  /// which it exerts no force. No allocation.
  void Damp(double damping, const Points& from);
  double damping() const { return damping_; }

  /// Returns (E_finite - E_small) / E at U without the damper; 0 if E is 0. This is dE/ds over E
  /// under contacts, which do no work when s changes. Requires that the last Gradient() was at U.
  double ShareSlope(const Points& U);

  int control_points() const override { return finite_->control_points(); }
  double Energy(const Points& U) override;
  double Gradient(const Points& U, Points* gradient) override;
  void Hessian(const Points& U, bool semi_definite, FullStiffness* K) override;
  double CollapsedShare(const Points& U) override { return finite_->CollapsedShare(U); }
  Matrix3d MeanRotation(const Points& U) override { return finite_->MeanRotation(U); }

 private:
  double Pull(double stiffness, const FullStiffness& K, const Points& away);
  const FullStiffness& damper() const { return K_t_.size() > 0 ? K_t_ : K_; }

  Cloned<ElasticEnergy> finite_;
  FullStiffness K_;
  FullStiffness K_t_;  // empty: K
  const SchurComplement* functions_;
  double share_ = 1;
  double damping_ = 0;
  double finite_energy_ = 0;  // J, E_finite at the last Gradient()
  Points from_;               // (n + slots) x 3, m
  Points away_;               // m: U - from
  Points pull_;               // N
  Eigen::VectorXd lattice_;   // 3n, m: away_ without the local functions (schur_complement.h)
};

}  // namespace hpdm
