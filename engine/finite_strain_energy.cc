#include "engine/finite_strain_energy.h"

#include <algorithm>
#include <array>

namespace hpdm {

FiniteStrainEnergy::FiniteStrainEnergy(const Lattice& lattice, const Quadrature& tissue,
                                       const HyperelasticLaw& law, const ScalarStiffness& supports)
    : n_(lattice.size()),
      law_(law),
      supports_(supports),
      support_stiffness_(FullStiffness::Zero(3 * n_, 3 * n_)) {
  AddAlongEachAxis(supports, &support_stiffness_);
  const std::array<WeightMatrix, 3> gradients = lattice.GradientWeights(tissue.points);
  const auto columns_at = [&](Eigen::Index q) {
    std::vector<int> columns;
    for (WeightMatrix::InnerIterator it(gradients[0], q); it; ++it) columns.push_back(it.index());
    return columns;
  };
  // Points come cell by cell, so those with the same functions follow each other.
  const Eigen::Index count = tissue.weights.size();
  std::vector<int> columns = columns_at(0);
  for (Eigen::Index begin = 0, end = 0; begin < count; begin = end) {
    Cell cell;
    cell.columns = columns;
    while (end < count && columns == cell.columns) {
      ++end;
      if (end < count) columns = columns_at(end);
    }
    cell.weights = tissue.weights.segment(begin, end - begin);
    cell.gradients.setZero(3 * (end - begin), static_cast<Eigen::Index>(cell.columns.size()));
    for (Eigen::Index q = begin; q < end; ++q) {
      for (int d = 0; d < 3; ++d) {
        Eigen::Index a = 0;
        for (WeightMatrix::InnerIterator it(gradients[d], q); it; ++it, ++a) {
          cell.gradients(3 * (q - begin) + d, a) = it.value();
        }
      }
    }
    tangents_.resize(std::max(tangents_.size(), static_cast<std::size_t>(end - begin)));
    cells_.push_back(std::move(cell));
  }
}

void FiniteStrainEnergy::GatherDeformation(const Cell& cell, const Points& U) {
  local_.resize(static_cast<Eigen::Index>(cell.columns.size()), 3);
  for (std::size_t a = 0; a < cell.columns.size(); ++a) {
    local_.row(static_cast<Eigen::Index>(a)) = U.row(cell.columns[a]);
  }
  deformation_.noalias() = cell.gradients * local_;
}

double FiniteStrainEnergy::Energy(const Points& U) {
  double energy = U.cwiseProduct(supports_ * U).sum() / 2;
  for (const Cell& cell : cells_) {
    GatherDeformation(cell, U);
    for (Eigen::Index q = 0; q < cell.weights.size(); ++q) {
      energy += cell.weights[q] * law_.Energy(DeformationAt(q));
    }
  }
  return energy;
}

double FiniteStrainEnergy::Gradient(const Points& U, Points* gradient) {
  gradient->noalias() = supports_ * U;
  double energy = U.cwiseProduct(*gradient).sum() / 2;
  for (const Cell& cell : cells_) {
    GatherDeformation(cell, U);
    stress_.resize(deformation_.rows(), 3);
    for (Eigen::Index q = 0; q < cell.weights.size(); ++q) {
      const Matrix3d F = DeformationAt(q);
      energy += cell.weights[q] * law_.Energy(F);
      stress_.middleRows<3>(3 * q) = cell.weights[q] * law_.Stress(F).transpose();
    }
    local_.noalias() = cell.gradients.transpose() * stress_;
    for (std::size_t a = 0; a < cell.columns.size(); ++a) {
      gradient->row(cell.columns[a]) += local_.row(static_cast<Eigen::Index>(a));
    }
  }
  return energy;
}

void FiniteStrainEnergy::Hessian(const Points& U, bool semi_definite, FullStiffness* K) {
  *K = support_stiffness_;
  for (const Cell& cell : cells_) {
    GatherDeformation(cell, U);
    for (Eigen::Index q = 0; q < cell.weights.size(); ++q) {
      Matrix9d& A = tangents_[static_cast<std::size_t>(q)];
      A = law_.Tangent(DeformationAt(q));
      if (semi_definite) A = ProjectedToSemiDefinite(A);
      A *= cell.weights[q];
    }
    // The (i, k) part couples displacements along i and k: sum_q G_q^T A_q^ik G_q with A^ik (3 x 3)
    // over the directions of the two gradients. Part (k, i) is its transpose.
    product_.resize(cell.gradients.rows(), cell.gradients.cols());
    for (int i = 0; i < 3; ++i) {
      for (int k = i; k < 3; ++k) {
        for (Eigen::Index q = 0; q < cell.weights.size(); ++q) {
          Matrix3d part;
          for (int j = 0; j < 3; ++j) {
            for (int l = 0; l < 3; ++l) {
              part(j, l) = tangents_[static_cast<std::size_t>(q)](3 * j + i, 3 * l + k);
            }
          }
          product_.middleRows<3>(3 * q).noalias() = part * cell.gradients.middleRows<3>(3 * q);
        }
        block_.noalias() = cell.gradients.transpose() * product_;
        for (Eigen::Index b = 0; b < block_.cols(); ++b) {
          for (Eigen::Index a = 0; a < block_.rows(); ++a) {
            const int row = 3 * cell.columns[a] + i, column = 3 * cell.columns[b] + k;
            (*K)(row, column) += block_(a, b);
            if (i != k) (*K)(column, row) += block_(a, b);
          }
        }
      }
    }
  }
}

}  // namespace hpdm
