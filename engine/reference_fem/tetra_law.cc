#include "engine/reference_fem/tetra_law.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace hpdm {
namespace {

using Vector9d = Eigen::Matrix<double, 9, 1>;

/// dJ/dF: its columns are the cross products of F's other two.
Matrix3d Cofactor(const Matrix3d& F) {
  Matrix3d cofactor;
  cofactor << F.col(1).cross(F.col(2)), F.col(2).cross(F.col(0)), F.col(0).cross(F.col(1));
  return cofactor;
}

Matrix3d CrossMatrix(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

}  // namespace

TetraMaterial::TetraMaterial(const MaterialOptions& material, TetraLaw law) : law_(law) {
  const double E = material.young, nu = material.poisson;
  mu_ = E / (2 * (1 + nu));
  lambda_ = E * nu / ((1 + nu) * (1 - 2 * nu));
  if (law == TetraLaw::kNeoHookean) {
    lambda_ += 5.0 / 6 * mu_;
    mu_ *= 4.0 / 3;
  }
  rest_ = 1 + 0.75 * mu_ / lambda_;
}

double TetraMaterial::Density(const Matrix3d& F) const {
  if (law_ == TetraLaw::kSmallStrain) {
    const Matrix3d e = (F + F.transpose()) / 2 - Matrix3d::Identity();
    return mu_ * e.squaredNorm() + lambda_ / 2 * e.trace() * e.trace();
  }
  const double I = F.squaredNorm(), J = F.determinant();
  return mu_ / 2 * (I - 3) + lambda_ / 2 * (J - rest_) * (J - rest_) - mu_ / 2 * std::log(I + 1);
}

Matrix3d TetraMaterial::Stress(const Matrix3d& F) const {
  if (law_ == TetraLaw::kSmallStrain) {
    const Matrix3d e = (F + F.transpose()) / 2 - Matrix3d::Identity();
    return 2 * mu_ * e + lambda_ * e.trace() * Matrix3d::Identity();
  }
  const double I = F.squaredNorm();
  return mu_ * (1 - 1 / (I + 1)) * F + lambda_ * (F.determinant() - rest_) * Cofactor(F);
}

Matrix9d TetraMaterial::Tangent(const Matrix3d& F, bool convex) const {
  Matrix9d C = Matrix9d::Zero();
  if (law_ == TetraLaw::kSmallStrain) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        C(i + 3 * j, i + 3 * j) += mu_;
        C(i + 3 * j, j + 3 * i) += mu_;
        C(4 * i, 4 * j) += lambda_;
      }
    }
    return C;
  }
  const double I = F.squaredNorm();
  const Matrix3d cofactor = Cofactor(F);
  const Eigen::Map<const Vector9d> f(F.data()), g(cofactor.data());
  C = mu_ * (1 - 1 / (I + 1)) * Matrix9d::Identity() +
      2 * mu_ / ((I + 1) * (I + 1)) * f * f.transpose() + lambda_ * g * g.transpose();
  const double pressure = lambda_ * (F.determinant() - rest_);
  for (int j = 0; j < 3; ++j) {  // d(col j of dJ/dF) / d(col j + 1) = -[col j + 2]x and so on
    const int k = (j + 1) % 3, l = (j + 2) % 3;
    C.block<3, 3>(3 * j, 3 * k) -= pressure * CrossMatrix(F.col(l));
    C.block<3, 3>(3 * j, 3 * l) += pressure * CrossMatrix(F.col(k));
  }
  if (convex) {
    const Eigen::SelfAdjointEigenSolver<Matrix9d> eigen(C);
    if (eigen.eigenvalues()[0] < 0) {
      C = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() *
          eigen.eigenvectors().transpose();
    }
  }
  return C;
}

}  // namespace hpdm
