#include "engine/hyperelastic.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

namespace hpdm {
namespace {

using Vector9d = Eigen::Matrix<double, 9, 1>;

Matrix3d GreenStrain(const Matrix3d& F) { return (F.transpose() * F - Matrix3d::Identity()) / 2; }

// dJ/dF: the cofactors.
Matrix3d JacobianGradient(const Matrix3d& F) {
  Matrix3d G;
  G << F.col(1).cross(F.col(2)), F.col(2).cross(F.col(0)), F.col(0).cross(F.col(1));
  return G;
}

Matrix3d CrossMatrix(const Vector3d& v) {
  Matrix3d C;
  C << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return C;
}

}  // namespace

HyperelasticLaw::HyperelasticLaw(MaterialLaw law, const LameParameters& lame)
    : law_(law), m_(lame.mu), l_(lame.lambda), alpha_(1), rest_(0) {
  if (law_ == MaterialLaw::kStVenantKirchhoff) return;
  m_ = 4 * lame.mu / 3;
  l_ = lame.lambda + 5 * lame.mu / 6;
  alpha_ = 1 + 3 * m_ / (4 * l_);
  rest_ = l_ / 2 * (1 - alpha_) * (1 - alpha_) - m_ / 2 * std::log(4.0);
}

double HyperelasticLaw::Energy(const Matrix3d& F) const {
  if (law_ == MaterialLaw::kStVenantKirchhoff) {
    const Matrix3d E = GreenStrain(F);
    return m_ * E.squaredNorm() + l_ / 2 * E.trace() * E.trace();
  }
  const double I_C = F.squaredNorm();
  const double change = F.determinant() - alpha_;
  return m_ / 2 * (I_C - 3 - std::log(I_C + 1)) + l_ / 2 * change * change - rest_;
}

Matrix3d HyperelasticLaw::Stress(const Matrix3d& F) const {
  if (law_ == MaterialLaw::kStVenantKirchhoff) {
    const Matrix3d E = GreenStrain(F);
    return F * (2 * m_ * E + l_ * E.trace() * Matrix3d::Identity());
  }
  const double I_C = F.squaredNorm();
  return m_ * (1 - 1 / (I_C + 1)) * F + l_ * (F.determinant() - alpha_) * JacobianGradient(F);
}

Matrix9d HyperelasticLaw::Tangent(const Matrix3d& F) const {
  Matrix9d A;
  if (law_ == MaterialLaw::kStVenantKirchhoff) {
    // P = F S: dP = dF S + F (2 mu dE + lambda tr(dE) I), with dE = sym(F^T dF).
    const Matrix3d E = GreenStrain(F);
    const Matrix3d S = 2 * m_ * E + l_ * E.trace() * Matrix3d::Identity();
    const Matrix3d left = F * F.transpose();
    for (int j = 0; j < 3; ++j) {
      for (int l = 0; l < 3; ++l) {
        A.block<3, 3>(3 * j, 3 * l) = S(j, l) * Matrix3d::Identity() +
                                      m_ * F.col(l) * F.col(j).transpose() +
                                      l_ * F.col(j) * F.col(l).transpose();
        if (j == l) A.block<3, 3>(3 * j, 3 * l) += m_ * left;
      }
    }
    return A;
  }
  const double I_C = F.squaredNorm();
  const Matrix3d gradient = JacobianGradient(F);
  const Eigen::Map<const Vector9d> f(F.data()), g(gradient.data());
  A = l_ * g * g.transpose() + 2 * m_ / ((I_C + 1) * (I_C + 1)) * f * f.transpose();
  A.diagonal().array() += m_ * (1 - 1 / (I_C + 1));
  // The Hessian of J is made of the cross products with F's columns.
  const double pressure = l_ * (F.determinant() - alpha_);
  for (int j = 0; j < 3; ++j) {
    const Matrix3d cross = pressure * CrossMatrix(F.col(j));
    const int next = (j + 1) % 3, last = (j + 2) % 3;
    A.block<3, 3>(3 * last, 3 * next) += cross;
    A.block<3, 3>(3 * next, 3 * last) -= cross;
  }
  return A;
}

Matrix9d ProjectedToSemiDefinite(const Matrix9d& tangent) {
  const Eigen::SelfAdjointEigenSolver<Matrix9d> eigen(tangent);
  if (eigen.eigenvalues()[0] >= 0) return tangent;
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).asDiagonal() *
         eigen.eigenvectors().transpose();
}

}  // namespace hpdm
