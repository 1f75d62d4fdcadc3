#include "engine/energy/strain_energy.h"

#include <algorithm>
#include <array>

#include "engine/base/add_product.h"
#include "engine/base/check.h"
#include "engine/energy/mixed_dilatation.h"

namespace hpdm {

LameParameters ToLame(const MaterialOptions& material) {
  const double E = material.young, nu = material.poisson;
  HPDM_CHECK(E > 0 && nu > -1 && nu < 0.5);
  return {.mu = E / (2 * (1 + nu)), .lambda = E * nu / ((1 + nu) * (1 - 2 * nu))};
}

DilatationShare ShareLambda(const LameParameters& lame, Dilatation dilatation) {
  if (dilatation == Dilatation::kPointwise) return {.pointwise = lame.lambda};
  const double pointwise = std::min(lame.lambda, 2 * lame.mu);
  return {.pointwise = pointwise, .projected = lame.lambda - pointwise};
}

FullStiffness StrainStiffness(const Lattice& lattice, const Quadrature& tissue,
                              const MaterialOptions& material, Dilatation dilatation) {
  const LameParameters lame = ToLame(material);
  const auto [pointwise, projected] = ShareLambda(lame, dilatation);
  const std::array<WeightMatrix, 3> gradients = lattice.GradientWeights(tissue.points);
  FullStiffness K = FullStiffness::Zero(3 * lattice.size(), 3 * lattice.size());
  AddElasticBlocks(
      gradients, gradients, tissue.weights, {lame.mu, pointwise},
      [&K](Eigen::Index row, Eigen::Index column, double value) { K(row, column) += value; });
  // Makes K symmetric to the last bit, whatever the order of summation.
  K = 0.5 * (K + K.transpose()).eval();
  if (projected > 0) {
    const Eigen::MatrixXd P = ProjectedDilatation(lattice, tissue).transpose();
    AddProductToLower(projected, P, P, K);
    K.triangularView<Eigen::StrictlyUpper>() = K.transpose();
  }
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
