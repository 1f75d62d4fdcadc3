#include "engine/energy/finite_strain_energy.h"

#include <algorithm>
#include <array>

#include "engine/energy/mixed_dilatation.h"

namespace hpdm {
namespace {

std::vector<int> ColumnsAt(const WeightMatrix& weights, Eigen::Index row) {
  std::vector<int> columns;
  for (WeightMatrix::InnerIterator it(weights, row); it; ++it) columns.push_back(it.index());
  return columns;
}

}  // namespace

FiniteStrainEnergy::FiniteStrainEnergy(const Lattice& lattice, const Quadrature& tissue,
                                       MaterialLaw law, const LameParameters& lame,
                                       Dilatation dilatation, const ScalarStiffness& supports)
    : n_(lattice.size()),
      law_(law, {lame.mu, ShareLambda(lame, dilatation).pointwise}),
      lambda_(ShareLambda(lame, dilatation).projected),
      supports_(supports),
      support_stiffness_(FullStiffness::Zero(3 * n_, 3 * n_)) {
  AddAlongEachAxis(supports, &support_stiffness_);
  const Eigen::Index count = tissue.weights.size();
  WeightMatrix moments(count, 0);
  if (lambda_ > 0) {
    const CoarserSplines splines(lattice, tissue);
    moments = splines.weighted_values();
    factor_ = splines.factor();
    dilatations_.resize(moments.cols(), 3 * n_);
  }
  pressure_.setZero(moments.cols());
  const std::array<WeightMatrix, 3> gradients = lattice.GradientWeights(tissue.points);
  // Points come cell by cell, so points with the same functions follow each other.
  for (Eigen::Index begin = 0, end = 0; begin < count; begin = end) {
    const std::vector<int> columns = ColumnsAt(gradients[0], begin);
    const std::vector<int> coarser = ColumnsAt(moments, begin);
    while (end < count && ColumnsAt(gradients[0], end) == columns &&
           ColumnsAt(moments, end) == coarser) {
      ++end;
    }
    AddCell(gradients, moments, tissue.weights, begin, end);
  }
}

void FiniteStrainEnergy::AddCell(const std::array<WeightMatrix, 3>& gradients,
                                 const WeightMatrix& moments, const Eigen::VectorXd& weights,
                                 Eigen::Index begin, Eigen::Index end) {
  Cell cell;
  cell.columns = ColumnsAt(gradients[0], begin);
  cell.coarser = ColumnsAt(moments, begin);
  cell.weights = weights.segment(begin, end - begin);
  cell.gradients.setZero(3 * (end - begin), static_cast<Eigen::Index>(cell.columns.size()));
  cell.moments.setZero(end - begin, static_cast<Eigen::Index>(cell.coarser.size()));
  for (Eigen::Index q = begin; q < end; ++q) {
    for (int d = 0; d < 3; ++d) {
      Eigen::Index a = 0;
      for (WeightMatrix::InnerIterator it(gradients[d], q); it; ++it, ++a) {
        cell.gradients(3 * (q - begin) + d, a) = it.value();
      }
    }
    Eigen::Index b = 0;
    for (WeightMatrix::InnerIterator it(moments, q); it; ++it, ++b) {
      cell.moments(q - begin, b) = it.value();
    }
  }
  tangents_.resize(std::max(tangents_.size(), static_cast<std::size_t>(end - begin)));
  cells_.push_back(std::move(cell));
}

void FiniteStrainEnergy::GatherDeformation(const Cell& cell, const Points& U) {
  local_.resize(static_cast<Eigen::Index>(cell.columns.size()), 3);
  for (std::size_t a = 0; a < cell.columns.size(); ++a) {
    local_.row(static_cast<Eigen::Index>(a)) = U.row(cell.columns[a]);
  }
  deformation_.noalias() = cell.gradients * local_;
}

// Computes the pressure of the projected dilatation. Returns its energy, lambda/2 |L^-1 moments|^2.
double FiniteStrainEnergy::Project(const Points& U) {
  if (lambda_ == 0) return 0;
  pressure_.setZero();
  for (const Cell& cell : cells_) {
    GatherDeformation(cell, U);
    for (Eigen::Index q = 0; q < cell.weights.size(); ++q) {
      const double theta = law_.Dilatation(DeformationAt(q));
      for (std::size_t b = 0; b < cell.coarser.size(); ++b) {
        pressure_[cell.coarser[b]] += theta * cell.moments(q, static_cast<Eigen::Index>(b));
      }
    }
  }
  factor_.triangularView<Eigen::Lower>().solveInPlace(pressure_);
  const double energy = lambda_ / 2 * pressure_.squaredNorm();
  factor_.triangularView<Eigen::Lower>().transpose().solveInPlace(pressure_);
  pressure_ *= lambda_;
  return energy;
}

// Returns the pressure of the projected dilatation at a point, times the point's weight.
double FiniteStrainEnergy::PressureAt(const Cell& cell, Eigen::Index q) const {
  double pressure = 0;
  for (std::size_t b = 0; b < cell.coarser.size(); ++b) {
    pressure += pressure_[cell.coarser[b]] * cell.moments(q, static_cast<Eigen::Index>(b));
  }
  return pressure;
}

double FiniteStrainEnergy::Energy(const Points& U) {
  double energy = U.cwiseProduct(supports_ * U).sum() / 2 + Project(U);
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
  double energy = U.cwiseProduct(*gradient).sum() / 2 + Project(U);
  for (const Cell& cell : cells_) {
    GatherDeformation(cell, U);
    stress_.resize(deformation_.rows(), 3);
    for (Eigen::Index q = 0; q < cell.weights.size(); ++q) {
      const Matrix3d F = DeformationAt(q);
      energy += cell.weights[q] * law_.Energy(F);
      Matrix3d stress = cell.weights[q] * law_.Stress(F);
      if (lambda_ > 0) stress += PressureAt(cell, q) * law_.DilatationGradient(F);
      stress_.middleRows<3>(3 * q) = stress.transpose();
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
  Project(U);
  if (lambda_ > 0) AddDilatationStiffness(U, K);
  for (const Cell& cell : cells_) {
    GatherDeformation(cell, U);
    for (Eigen::Index q = 0; q < cell.weights.size(); ++q) {
      Matrix9d& A = tangents_[static_cast<std::size_t>(q)];
      const Matrix3d F = DeformationAt(q);
      A = cell.weights[q] * law_.Tangent(F);
      if (lambda_ > 0) law_.AddDilatationHessian(F, PressureAt(cell, q), &A);
      if (semi_definite) A = ProjectedToSemiDefinite(A);
    }
    // The (i, k) part couples displacements along i and k. It is sum_q G_q^T A_q^ik G_q, with A^ik
    // (3 x 3) over the directions of the two gradients. Part (k, i) is its transpose. All parts are
    // added below the diagonal.
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
          for (Eigen::Index a = i == k ? b : 0; a < block_.rows(); ++a) {
            const auto [column, row] =
                std::minmax({3 * cell.columns[a] + i, 3 * cell.columns[b] + k});
            (*K)(row, column) += block_(a, b);
          }
        }
      }
    }
  }
  K->triangularView<Eigen::StrictlyUpper>() = K->transpose();
}

double FiniteStrainEnergy::CollapsedShare(const Points& U) {
  double collapsed = 0, all = 0;
  for (const Cell& cell : cells_) {
    GatherDeformation(cell, U);
    for (Eigen::Index q = 0; q < cell.weights.size(); ++q) {
      all += cell.weights[q];
      if (law_.Collapsed(DeformationAt(q))) collapsed += cell.weights[q];
    }
  }
  return collapsed / all;
}

// Adds lambda D^T D below the diagonal, with D = L^-1 int psi d theta / dU dV.
void FiniteStrainEnergy::AddDilatationStiffness(const Points& U, FullStiffness* K) {
  dilatations_.setZero();
  for (const Cell& cell : cells_) {
    GatherDeformation(cell, U);
    // d theta / dU_a along d = sum_l (d theta / dF)_dl d phi_a / dx_l.
    for (int d = 0; d < 3; ++d) {
      product_.resize(cell.weights.size(), cell.gradients.cols());
      for (Eigen::Index q = 0; q < cell.weights.size(); ++q) {
        const Matrix3d H = law_.DilatationGradient(DeformationAt(q));
        product_.row(q).noalias() = H.row(d) * cell.gradients.middleRows<3>(3 * q);
      }
      block_.noalias() = cell.moments.transpose() * product_;
      for (std::size_t a = 0; a < cell.columns.size(); ++a) {
        for (std::size_t b = 0; b < cell.coarser.size(); ++b) {
          dilatations_(cell.coarser[b], 3 * cell.columns[a] + d) +=
              block_(static_cast<Eigen::Index>(b), static_cast<Eigen::Index>(a));
        }
      }
    }
  }
  factor_.triangularView<Eigen::Lower>().solveInPlace(dilatations_);
  K->selfadjointView<Eigen::Lower>().rankUpdate(dilatations_.transpose(), lambda_);
}

}  // namespace hpdm
