#include "engine/energy/hyperelastic.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

namespace hpdm {
namespace {

using Vector9d = Eigen::Matrix<double, 9, 1>;

Matrix3d GreenStrain(const Matrix3d& F) { return (F.transpose() * F - Matrix3d::Identity()) / 2; }

// Returns dJ/dF, the cofactor matrix.
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

// Coefficients of the Neo-Hookean W_0 in units of mu:
// W_0 = m/2 (I_C - 3 - log(I_C + 1)) + l_0/2 (J - alpha_0)^2 - (the same at rest).
constexpr double kM = 4.0 / 3, kL0 = 5.0 / 6, kAlpha0 = 11.0 / 5;

}  // namespace

HyperelasticLaw::HyperelasticLaw(MaterialLaw law, const LameParameters& lame)
    : law_(law), mu_(lame.mu), lambda_(lame.lambda) {}

bool HyperelasticLaw::Collapsed(const Matrix3d& F) const {
  if (!(F.determinant() > 0)) return true;
  if (law_ != MaterialLaw::kStVenantKirchhoff) return false;
  Eigen::SelfAdjointEigenSolver<Matrix3d> stretches;
  stretches.computeDirect(F.transpose() * F, Eigen::EigenvaluesOnly);
  return stretches.eigenvalues()[0] < 1.0 / 3;
}

double HyperelasticLaw::Dilatation(const Matrix3d& F) const {
  return law_ == MaterialLaw::kStVenantKirchhoff ? GreenStrain(F).trace() : F.determinant() - 1;
}

Matrix3d HyperelasticLaw::DilatationGradient(const Matrix3d& F) const {
  return law_ == MaterialLaw::kStVenantKirchhoff ? F : JacobianGradient(F);
}

void HyperelasticLaw::AddDilatationHessian(const Matrix3d& F, double pressure, Matrix9d* A) const {
  if (law_ == MaterialLaw::kStVenantKirchhoff) {
    A->diagonal().array() += pressure;
    return;
  }
  // The Hessian of J consists of the cross-product matrices of F's columns.
  for (int j = 0; j < 3; ++j) {
    const Matrix3d cross = pressure * CrossMatrix(F.col(j));
    const int next = (j + 1) % 3, last = (j + 2) % 3;
    A->block<3, 3>(3 * last, 3 * next) += cross;
    A->block<3, 3>(3 * next, 3 * last) -= cross;
  }
}

// Returns l (J - alpha), the factor of dJ/dF in the Neo-Hookean stress.
double HyperelasticLaw::Pressure(double theta) const {
  return lambda_ * theta + mu_ * kL0 * (theta + 1 - kAlpha0);
}

double HyperelasticLaw::Energy(const Matrix3d& F) const {
  const double theta = Dilatation(F);
  const double volumetric = lambda_ / 2 * theta * theta;
  if (law_ == MaterialLaw::kStVenantKirchhoff)
    return mu_ * GreenStrain(F).squaredNorm() + volumetric;
  // Avoids cancellation at rest: log((I_C + 1) / 4) as log1p of the small change, and
  // (J - alpha)^2 - (1 - alpha)^2 as a product.
  const double change = F.squaredNorm() - 3;
  return mu_ * (kM / 2 * (change - std::log1p(change / 4)) +
                kL0 / 2 * theta * (theta + 2 * (1 - kAlpha0))) +
         volumetric;
}

Matrix3d HyperelasticLaw::Stress(const Matrix3d& F) const {
  const double theta = Dilatation(F);
  if (law_ == MaterialLaw::kStVenantKirchhoff) {
    return F * (2 * mu_ * GreenStrain(F) + lambda_ * theta * Matrix3d::Identity());
  }
  const double shape = mu_ * kM * (1 - 1 / (F.squaredNorm() + 1));
  return shape * F + Pressure(theta) * JacobianGradient(F);
}

Matrix9d HyperelasticLaw::Tangent(const Matrix3d& F) const {
  Matrix9d A;
  const double theta = Dilatation(F);
  if (law_ == MaterialLaw::kStVenantKirchhoff) {
    // P = F S: dP = dF S + F (2 mu dE + lambda tr(dE) I), with dE = sym(F^T dF).
    const Matrix3d S = 2 * mu_ * GreenStrain(F) + lambda_ * theta * Matrix3d::Identity();
    const Matrix3d left = F * F.transpose();
    for (int j = 0; j < 3; ++j) {
      for (int l = 0; l < 3; ++l) {
        A.block<3, 3>(3 * j, 3 * l) = S(j, l) * Matrix3d::Identity() +
                                      mu_ * F.col(l) * F.col(j).transpose() +
                                      lambda_ * F.col(j) * F.col(l).transpose();
        if (j == l) A.block<3, 3>(3 * j, 3 * l) += mu_ * left;
      }
    }
    return A;
  }
  const double I_C = F.squaredNorm();
  const Matrix3d gradient = JacobianGradient(F);
  const Eigen::Map<const Vector9d> f(F.data()), g(gradient.data());
  A = (lambda_ + mu_ * kL0) * g * g.transpose() +
      mu_ * 2 * kM / ((I_C + 1) * (I_C + 1)) * f * f.transpose();
  A.diagonal().array() += mu_ * kM * (1 - 1 / (I_C + 1));
  AddDilatationHessian(F, Pressure(theta), &A);
  return A;
}

Matrix9d ProjectedToSemiDefinite(const Matrix9d& tangent) {
  // The tangent is usually positive definite. A Cholesky factorisation shows that ten times faster
  // than eigenvalues.
  if (Eigen::LLT<Matrix9d>(tangent).info() == Eigen::Success) return tangent;
  const Eigen::SelfAdjointEigenSolver<Matrix9d> eigen(tangent);
  if (eigen.eigenvalues()[0] >= 0) return tangent;
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).asDiagonal() *
         eigen.eigenvectors().transpose();
}

}  // namespace hpdm
