#include "engine/solver/sparse_cholesky.h"

#include <Eigen/SparseCholesky>

#include "engine/base/error.h"

namespace hpdm {

SparseCholesky::SparseCholesky(const ScalarStiffness& A, const std::string& remedy) {
  using ColumnMajor = Eigen::SparseMatrix<double>;
  const Eigen::SimplicialLLT<ColumnMajor, Eigen::Lower, Eigen::AMDOrdering<int>> factor{
      ColumnMajor(A)};
  if (factor.info() != Eigen::Success) throw InputError(remedy);
  const ColumnMajor L = factor.matrixL();
  const auto& indices = factor.permutationP().indices();
  // A singular matrix leaves round-off in its last pivot.
  for (Eigen::Index i = 0; i < A.rows(); ++i) {
    const double pivot = L.coeff(indices[i], indices[i]);
    if (!(pivot * pivot > 1e-12 * A.coeff(i, i))) throw InputError(remedy);
  }
  place_.assign(indices.data(), indices.data() + indices.size());
  first_.push_back(0);
  for (Eigen::Index j = 0; j < L.cols(); ++j) {
    for (ColumnMajor::InnerIterator it(L, j); it; ++it) {
      if (it.row() == j) {
        inverse_diagonal_.push_back(1 / it.value());
      } else {
        rows_.push_back(static_cast<int>(it.row()));
        values_.push_back(it.value());
      }
    }
    first_.push_back(rows_.size());
  }
}

void SparseCholesky::SolveLower(Points* x) const {
  double* const p = x->data();
  for (Eigen::Index j = 0; j < size(); ++j) {
    double* const pj = p + 3 * j;
    const double inverse = inverse_diagonal_[j];
    const double x0 = pj[0] * inverse, x1 = pj[1] * inverse, x2 = pj[2] * inverse;
    pj[0] = x0, pj[1] = x1, pj[2] = x2;
    for (std::size_t k = first_[j]; k < first_[j + 1]; ++k) {
      double* const pi = p + 3 * static_cast<std::ptrdiff_t>(rows_[k]);
      const double l = values_[k];
      pi[0] -= l * x0, pi[1] -= l * x1, pi[2] -= l * x2;
    }
  }
}

void SparseCholesky::SolveLowerSparse(Eigen::Ref<Eigen::VectorXd> x) const {
  for (Eigen::Index j = 0; j < size(); ++j) {
    if (x[j] == 0) continue;
    const double xj = x[j] * inverse_diagonal_[j];
    x[j] = xj;
    for (std::size_t k = first_[j]; k < first_[j + 1]; ++k) x[rows_[k]] -= values_[k] * xj;
  }
}

void SparseCholesky::SolveUpper(Points* x) const {
  double* const p = x->data();
  for (Eigen::Index j = size() - 1; j >= 0; --j) {
    double* const pj = p + 3 * j;
    double x0 = pj[0], x1 = pj[1], x2 = pj[2];
    for (std::size_t k = first_[j]; k < first_[j + 1]; ++k) {
      const double* const pi = p + 3 * static_cast<std::ptrdiff_t>(rows_[k]);
      const double l = values_[k];
      x0 -= l * pi[0], x1 -= l * pi[1], x2 -= l * pi[2];
    }
    const double inverse = inverse_diagonal_[j];
    pj[0] = x0 * inverse, pj[1] = x1 * inverse, pj[2] = x2 * inverse;
  }
}

void SparseCholesky::Solve(Eigen::Ref<Points> x) const {
  Points ordered(size(), 3);
  for (Eigen::Index i = 0; i < size(); ++i) ordered.row(place_[i]) = x.row(i);
  SolveLower(&ordered);
  SolveUpper(&ordered);
  for (Eigen::Index i = 0; i < size(); ++i) x.row(i) = ordered.row(place_[i]);
}

}  // namespace hpdm
