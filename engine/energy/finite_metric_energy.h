#pragma once

#include <utility>
#include <vector>

#include "engine/base/quadrature.h"
#include "engine/energy/elastic_energy.h"
#include "engine/energy/metric_energy.h"
#include "engine/lattice/lattice.h"

namespace hpdm {

/// The paper's energy of a solid without its linearisation (Eq. 14-17, beta as in metric_energy.h):
///     E(U) = int eta sum_ij (G_ij - G0_ij)^2 + beta/2 sum_k |d_kk x|^2 dV + supports
/// with the metric tensor G_ij = d_i x . d_j x along the lattice's axes, by differences of the
/// control points' positions.
///
/// 1. The variation has alpha_ij = 4 eta (G_ij - G0_ij); the printed Eq. 17 lacks the factor 4.
///    Gradient() evaluates it at every U, so rotations cost nothing.
/// 2. The law is St. Venant-Kirchhoff with mu = 4 eta, lambda = 0. It does not couple the axes. In
///    strong compression it is not convex and collapses.
/// 3. G_ii is taken along each pair of neighbours, G_ij between the mean differences along i and j
///    of each square of four control points.
/// 4. Each component is weighted by the tissue under the functions that multiply it in the
///    derivatives of the lattice map. So the weights of one component add up to the tissue's
///    volume.
/// 5. The second differences d_kk x vanish for every linear map.
class FiniteMetricEnergy final : public ElasticEnergy {
 public:
  /// `eta`: Pa; `beta`: N; `tissue`: as for MetricStiffness; `supports`: n x n, N/m.
  FiniteMetricEnergy(const Lattice& lattice, const Quadrature& tissue, double eta, double beta,
                     const ScalarStiffness& supports);

  std::unique_ptr<ElasticEnergy> Clone() const override {
    return std::make_unique<FiniteMetricEnergy>(*this);
  }
  void Take(const ElasticEnergy& other) override {
    *this = static_cast<const FiniteMetricEnergy&>(other);
  }
  int control_points() const override { return static_cast<int>(rest_.rows()); }
  double Energy(const Points& U) override;
  double Gradient(const Points& U, Points* gradient) override;
  void Hessian(const Points& U, bool semi_definite, FullStiffness* K) override;
  double CollapsedShare(const Points& U) override;

 private:
  // Energy eta w (g . g - 1)^2 with g = (x_b - x_a) / h.
  struct Edge {
    int a, b;
    double inverse_h, weight;  // 1/m; eta times m^3, J
  };
  // Energy 2 eta w (g . k)^2 with g, k = sums of +-x / 2h over the corners 00, 01, 10, 11.
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
