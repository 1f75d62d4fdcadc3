#pragma once

#include <utility>
#include <vector>

#include "engine/base/quadrature.h"
#include "engine/energy/elastic_energy.h"
#include "engine/energy/metric_energy.h"
#include "engine/lattice/lattice.h"

namespace hpdm {

/// The paper's energy of a solid without its linearisation (Eq. 14-17 with beta as in
/// metric_energy.h):
///     E(U) = int eta sum_ij (G_ij - G0_ij)^2 + beta/2 sum_k |d_kk x|^2 dV + supports,
/// with the metric tensor G_ij = d_i x . d_j x of the control points' positions along the lattice's
/// axes, by differences. Its variation has alpha_ij = 4 eta (G_ij - G0_ij) (Eq. 17 with the factor
/// that the printed one lacks), which Gradient() computes anew at every U: rotations are free, and
/// the shear modulus at rest is 4 eta (St. Venant-Kirchhoff with mu = 4 eta, lambda = 0: it does
/// not couple the axes, and collapses in strong compression, where it is not convex).
///
/// G_ii is taken along each pair of neighbours, G_ij between the mean differences along i and j of
/// each square of four; each is weighted by the tissue under the functions that multiply it in the
/// derivatives of the lattice map, so that the weights of one component add up to the tissue's
/// volume. The second differences vanish for every linear map.
class FiniteMetricEnergy final : public ElasticEnergy {
 public:
  /// eta in Pa, beta in N; `tissue` as of MetricStiffness. `supports` (n x n, N/m).
  FiniteMetricEnergy(const Lattice& lattice, const Quadrature& tissue, double eta, double beta,
                     const ScalarStiffness& supports);

  std::unique_ptr<ElasticEnergy> Clone() const override {
    return std::make_unique<FiniteMetricEnergy>(*this);
  }
  int control_points() const override { return static_cast<int>(rest_.rows()); }
  double Energy(const Points& U) override;
  double Gradient(const Points& U, Points* gradient) override;
  void Hessian(const Points& U, bool semi_definite, FullStiffness* K) override;
  double CollapsedShare(const Points& U) override;

 private:
  // eta w (g . g - 1)^2 with g = (x_b - x_a) / h.
  struct Edge {
    int a, b;
    double inverse_h, weight;  // 1/m; eta times m^3, J
  };
  // 2 eta w (g . k)^2 with g, k = sums of +-x / 2h over the corners 00, 01, 10, 11 of a square.
  struct Square {
    int corners[4];
    double inverse_g, inverse_k, weight;
  };
  std::pair<Vector3d, Vector3d> Differences(const Square& square) const;

  Points rest_;             // n x 3: control points at rest
  ScalarStiffness linear_;  // n x n: second differences and supports
  FullStiffness linear_full_;
  std::vector<Edge> edges_;
  std::vector<Square> squares_;
  Points x_;  // n x 3
};

}  // namespace hpdm
