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

// Returns the columns of a row's entries.
std::vector<Eigen::Index> ColumnsOf(const WeightMatrix& weights, Eigen::Index row) {
  std::vector<Eigen::Index> columns;
  for (WeightMatrix::InnerIterator it(weights, row); it; ++it) columns.push_back(it.col());
  return columns;
}

// Adds the elastic blocks of the points begin .. end - 1, at which the same functions are non-zero,
// as dense products.
void AddAtPoints(const std::array<WeightMatrix, 3>& gradients, const Eigen::VectorXd& weights,
                 Eigen::Index begin, Eigen::Index end, const LameParameters& lame,
                 FullStiffness* K) {
  const std::vector<Eigen::Index> columns = ColumnsOf(gradients[0], begin);
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

// Calls f(begin, end) for the runs of points at which the same functions are non-zero.
template <typename Function>
void ForEachRun(const WeightMatrix& weights, Function&& f) {
  for (Eigen::Index begin = 0, end = 0; begin < weights.rows(); begin = end) {
    while (end < weights.rows() && SameColumns(weights, begin, end)) ++end;
    f(begin, end);
  }
}

// Does the same as AddElasticBlocks, a few times as fast where many functions share points that
// follow each other.
void AddCellByCell(const std::array<WeightMatrix, 3>& gradients, const Eigen::VectorXd& weights,
                   const LameParameters& lame, FullStiffness* K) {
  ForEachRun(gradients[0], [&](Eigen::Index begin, Eigen::Index end) {
    AddAtPoints(gradients, weights, begin, end, lame, K);
  });
}

// Adds to G (3n x 3n) the integrals of the products of gradients, int d_i phi_a d_j phi_b dV at row
// 3 a + i and column 3 b + j. Each sum runs over the points in their order, as in a sparse product.
void AddGradientProducts(const std::array<WeightMatrix, 3>& gradients,
                         const Eigen::VectorXd& weights, FullStiffness* G) {
  constexpr Eigen::Index kPoints = 32;  // together, so that a column of the block is read once
  Eigen::MatrixXd gradient, weighted;   // of all functions at the points: 3m x kPoints
  Eigen::MatrixXd block;                // 3m x 3m
  ForEachRun(gradients[0], [&](Eigen::Index begin, Eigen::Index end) {
    const std::vector<Eigen::Index> columns = ColumnsOf(gradients[0], begin);
    const auto m = static_cast<Eigen::Index>(columns.size());
    block.resize(3 * m, 3 * m);
    for (Eigen::Index b = 0; b < m; ++b) {
      for (Eigen::Index a = 0; a < m; ++a) {
        block.block<3, 3>(3 * a, 3 * b) = G->block<3, 3>(3 * columns[a], 3 * columns[b]);
      }
    }
    gradient.resize(3 * m, kPoints);
    for (Eigen::Index first = begin; first < end; first += kPoints) {
      const Eigen::Index points = std::min(kPoints, end - first);
      for (Eigen::Index p = 0; p < points; ++p) {
        for (int d = 0; d < 3; ++d) {
          Eigen::Index a = 0;
          for (WeightMatrix::InnerIterator it(gradients[d], first + p); it; ++it) {
            gradient(3 * a++ + d, p) = it.value();
          }
        }
      }
      weighted = gradient.leftCols(points) * weights.segment(first, points).asDiagonal();
      for (Eigen::Index b = 0; b < 3 * m; ++b) {
        for (Eigen::Index p = 0; p < points; ++p) block.col(b) += gradient(b, p) * weighted.col(p);
      }
    }
    for (Eigen::Index b = 0; b < m; ++b) {
      for (Eigen::Index a = 0; a < m; ++a) {
        G->block<3, 3>(3 * columns[a], 3 * columns[b]) = block.block<3, 3>(3 * a, 3 * b);
      }
    }
  });
}

// Returns what AddElasticBlocks adds for these functions, bit for bit, in a fraction of its time.
FullStiffness ElasticStiffness(const std::array<WeightMatrix, 3>& gradients,
                               const Eigen::VectorXd& weights, const LameParameters& lame) {
  const Eigen::Index functions = gradients[0].cols();
  FullStiffness K = FullStiffness::Zero(3 * functions, 3 * functions);
  AddGradientProducts(gradients, weights, &K);
  for (Eigen::Index b = 0; b < functions; ++b) {
    for (Eigen::Index a = 0; a < functions; ++a) {
      const Matrix3d G = K.block<3, 3>(3 * a, 3 * b);
      Matrix3d of_pair = Matrix3d::Zero();
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
          of_pair(j, i) += lame.mu * G(i, j);
          of_pair(i, j) += lame.lambda * G(i, j);
          if (i == j) of_pair.diagonal().array() += lame.mu * G(i, i);
        }
      }
      K.block<3, 3>(3 * a, 3 * b) = of_pair;
    }
  }
  return K;
}

}  // namespace

FullStiffness StrainStiffness(const Lattice& lattice, const Quadrature& tissue,
                              const MaterialOptions& material, Dilatation dilatation) {
  const LameParameters lame = ToLame(material);
  const auto [pointwise, projected] = ShareLambda(lame, dilatation);
  const std::array<WeightMatrix, 3> gradients = lattice.GradientWeights(tissue.points);
  FullStiffness K;
  if (lattice.levels().empty()) {
    K = ElasticStiffness(gradients, tissue.weights, {lame.mu, pointwise});
  } else {
    K = FullStiffness::Zero(3 * lattice.size(), 3 * lattice.size());
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
