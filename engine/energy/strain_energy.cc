#include "engine/energy/strain_energy.h"

#include <algorithm>
#include <array>
#include <vector>

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

namespace {

// Adds the elastic blocks of the points begin .. end - 1, at which the same functions are non-zero,
// as dense products.
void AddAtPoints(const std::array<WeightMatrix, 3>& gradients, const Eigen::VectorXd& weights,
                 Eigen::Index begin, Eigen::Index end, const LameParameters& lame,
                 FullStiffness* K) {
  std::vector<Eigen::Index> columns;
  for (WeightMatrix::InnerIterator it(gradients[0], begin); it; ++it) columns.push_back(it.col());
  const auto m = static_cast<Eigen::Index>(columns.size());
  std::array<Eigen::MatrixXd, 3> g;
  for (int d = 0; d < 3; ++d) {
    g[d].resize(m, end - begin);
    for (Eigen::Index q = begin; q < end; ++q) {
      Eigen::Index a = 0;
      for (WeightMatrix::InnerIterator it(gradients[d], q); it; ++it)
        g[d](a++, q - begin) = it.value();
    }
  }
  for (int i = 0; i < 3; ++i) {
    const Eigen::MatrixXd weighted = g[i] * weights.segment(begin, end - begin).asDiagonal();
    for (int j = 0; j < 3; ++j) {
      const Eigen::MatrixXd G = weighted * g[j].transpose();
      for (Eigen::Index b = 0; b < m; ++b) {
        for (Eigen::Index a = 0; a < m; ++a) {
          (*K)(3 * columns[a] + j, 3 * columns[b] + i) += lame.mu * G(a, b);
          (*K)(3 * columns[a] + i, 3 * columns[b] + j) += lame.lambda * G(a, b);
          if (i != j) continue;
          for (int d = 0; d < 3; ++d) {
            (*K)(3 * columns[a] + d, 3 * columns[b] + d) += lame.mu * G(a, b);
          }
        }
      }
    }
  }
}

bool SameColumns(const WeightMatrix& weights, Eigen::Index a, Eigen::Index b) {
  WeightMatrix::InnerIterator x(weights, a), y(weights, b);
  for (; x && y; ++x, ++y) {
    if (x.col() != y.col()) return false;
  }
  return !x && !y;
}

// Does the same as AddElasticBlocks, a few times as fast where many functions share points that
// follow each other.
void AddCellByCell(const std::array<WeightMatrix, 3>& gradients, const Eigen::VectorXd& weights,
                   const LameParameters& lame, FullStiffness* K) {
  for (Eigen::Index begin = 0, end = 0; begin < weights.size(); begin = end) {
    while (end < weights.size() && SameColumns(gradients[0], begin, end)) ++end;
    AddAtPoints(gradients, weights, begin, end, lame, K);
  }
}

}  // namespace

FullStiffness StrainStiffness(const Lattice& lattice, const Quadrature& tissue,
                              const MaterialOptions& material, Dilatation dilatation) {
  const LameParameters lame = ToLame(material);
  const auto [pointwise, projected] = ShareLambda(lame, dilatation);
  const std::array<WeightMatrix, 3> gradients = lattice.GradientWeights(tissue.points);
  FullStiffness K = FullStiffness::Zero(3 * lattice.size(), 3 * lattice.size());
  if (lattice.levels().empty()) {
    AddElasticBlocks(
        gradients, gradients, tissue.weights, {lame.mu, pointwise},
        [&K](Eigen::Index row, Eigen::Index column, double value) { K(row, column) += value; });
  } else {
    AddCellByCell(gradients, tissue.weights, {lame.mu, pointwise}, &K);
  }
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
