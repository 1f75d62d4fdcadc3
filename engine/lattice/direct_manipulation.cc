#include "engine/lattice/direct_manipulation.h"

#include <Eigen/Eigenvalues>

#include "engine/base/check.h"

namespace hpdm {

int MoveDirectly(const Eigen::Ref<const ContactWeights>& weights,
                 const Eigen::Ref<const Points>& contact_change,
                 Eigen::Ref<Points> control_displacements) {
  using Gram = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxToolRows,
                             kMaxToolRows>;
  using Change = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::ColMajor, kMaxToolRows, 3>;
  const Eigen::Index m = weights.rows();
  HPDM_CHECK(m <= kMaxToolRows && contact_change.rows() == m);
  if (m == 0) return 0;

  Gram gram(m, m);
  for (Eigen::Index i = 0; i < m; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) gram(i, j) = weights.row(i).dot(weights.row(j));
  }
  const Eigen::SelfAdjointEigenSolver<Gram> eigen(gram);  // reads the lower triangle
  const double cutoff = 1e-10 * eigen.eigenvalues()[m - 1];
  if (!(cutoff > 0)) return 0;

  Change multipliers = eigen.eigenvectors().transpose() * contact_change;
  int rank = 0;
  for (Eigen::Index i = 0; i < m; ++i) {
    const double eigenvalue = eigen.eigenvalues()[i];
    if (eigenvalue > cutoff) {
      multipliers.row(i) /= eigenvalue;
      ++rank;
    } else {
      multipliers.row(i).setZero();
    }
  }
  const Change pull = eigen.eigenvectors() * multipliers;
  for (Eigen::Index i = 0; i < m; ++i) {
    for (int d = 0; d < 3; ++d) {
      control_displacements.col(d) += pull(i, d) * weights.row(i).transpose();
    }
  }
  return rank;
}

}  // namespace hpdm
