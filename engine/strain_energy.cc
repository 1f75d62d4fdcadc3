#include "engine/strain_energy.h"

#include <array>

#include "engine/check.h"
#include "engine/mixed_dilatation.h"

namespace hpdm {

LameParameters ToLame(const MaterialOptions& material) {
  const double E = material.young, nu = material.poisson;
  HPDM_CHECK(E > 0 && nu > -1 && nu < 0.5);
  return {.mu = E / (2 * (1 + nu)), .lambda = E * nu / ((1 + nu) * (1 - 2 * nu))};
}

FullStiffness StrainStiffness(const Lattice& lattice, const Quadrature& tissue,
                              const MaterialOptions& material, Dilatation dilatation) {
  const auto [mu, lambda] = ToLame(material);
  const int n = lattice.size();
  const bool pointwise = dilatation == Dilatation::kPointwise;
  const std::array<WeightMatrix, 3> gradients = lattice.GradientWeights(tissue.points);

  // The matrices G_ij = int d_i phi_a d_j phi_b dV (n x n each) hold all that K is made of:
  // K_(a,i),(b,j) = mu (delta_ij sum_k G_kk + G_ji) + lambda G_ij.
  FullStiffness K = FullStiffness::Zero(3 * n, 3 * n);
  for (int i = 0; i < 3; ++i) {
    const WeightMatrix left = tissue.weights.asDiagonal() * gradients[i];
    for (int j = 0; j < 3; ++j) {
      const WeightMatrix G = left.transpose() * gradients[j];
      for (int a = 0; a < n; ++a) {
        for (WeightMatrix::InnerIterator it(G, a); it; ++it) {
          const auto b = it.index();
          K(3 * a + j, 3 * b + i) += mu * it.value();
          if (pointwise) K(3 * a + i, 3 * b + j) += lambda * it.value();
          if (i != j) continue;
          for (int d = 0; d < 3; ++d) K(3 * a + d, 3 * b + d) += mu * it.value();
        }
      }
    }
  }
  if (!pointwise && lambda > 0) {
    const Eigen::MatrixXd P = ProjectedDilatation(lattice, tissue);
    K.noalias() += lambda * P.transpose() * P;
  }
  // Symmetric to the last bit, whatever the order of summation.
  K = 0.5 * (K + K.transpose()).eval();
  return K;
}

void AddAlongEachAxis(const Eigen::SparseMatrix<double, Eigen::RowMajor>& scalar,
                      FullStiffness* K) {
  HPDM_CHECK(K->rows() == 3 * scalar.rows());
  for (Eigen::Index a = 0; a < scalar.rows(); ++a) {
    for (WeightMatrix::InnerIterator it(scalar, a); it; ++it) {
      for (int d = 0; d < 3; ++d) (*K)(3 * a + d, 3 * it.index() + d) += it.value();
    }
  }
}

}  // namespace hpdm
