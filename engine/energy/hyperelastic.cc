#include "engine/energy/hyperelastic.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

#include "engine/base/check.h"

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

constexpr double kM = NeoHookean::kM, kL0 = NeoHookean::kL0, kAlpha0 = NeoHookean::kAlpha0;

}  // namespace

HyperelasticLaw::HyperelasticLaw(MaterialLaw law, const LameParameters& lame)
    : law_(law), mu_(lame.mu), lambda_(lame.lambda) {}

bool HyperelasticLaw::Collapsed(const Matrix3d& F) const {
  if (!(F.determinant() > 0)) return true;
  switch (law_) {
    case MaterialLaw::kNeoHookean:
      return false;
    case MaterialLaw::kStVenantKirchhoff: {
      Eigen::SelfAdjointEigenSolver<Matrix3d> stretches;
      stretches.computeDirect(F.transpose() * F, Eigen::EigenvaluesOnly);
      return stretches.eigenvalues()[0] < 1.0 / 3;
    }
  }
  HPDM_CHECK(false);
}

double HyperelasticLaw::Dilatation(const Matrix3d& F) const {
  switch (law_) {
    case MaterialLaw::kNeoHookean:
      return F.determinant() - 1;
    case MaterialLaw::kStVenantKirchhoff:
      return GreenStrain(F).trace();
  }
  HPDM_CHECK(false);
}

Matrix3d HyperelasticLaw::DilatationGradient(const Matrix3d& F) const {
  switch (law_) {
    case MaterialLaw::kNeoHookean:
      return JacobianGradient(F);
    case MaterialLaw::kStVenantKirchhoff:
      return F;
  }
  HPDM_CHECK(false);
}

void HyperelasticLaw::AddDilatationHessian(const Matrix3d& F, double pressure, Matrix9d* A) const {
  switch (law_) {
    case MaterialLaw::kNeoHookean:
      // The Hessian of J consists of the cross-product matrices of F's columns.
      for (int j = 0; j < 3; ++j) {
        const Matrix3d cross = pressure * CrossMatrix(F.col(j));
        const int next = (j + 1) % 3, last = (j + 2) % 3;
        A->block<3, 3>(3 * last, 3 * next) += cross;
        A->block<3, 3>(3 * next, 3 * last) -= cross;
      }
      break;
    case MaterialLaw::kStVenantKirchhoff:
      A->diagonal().array() += pressure;
      break;
  }
}

// Returns l (J - alpha), the factor of dJ/dF in the Neo-Hookean stress.
double HyperelasticLaw::Pressure(double theta) const {
  return lambda_ * theta + mu_ * kL0 * (theta + 1 - kAlpha0);
}

double HyperelasticLaw::Energy(const Matrix3d& F) const {
  const double theta = Dilatation(F);
  const double volumetric = lambda_ / 2 * theta * theta;
  switch (law_) {
    case MaterialLaw::kNeoHookean: {
      // Avoids cancellation at rest: log((I_C + 1) / 4) as log1p of the small change, and
      // (J - alpha)^2 - (1 - alpha)^2 as a product.
      const double change = F.squaredNorm() - 3;
      return mu_ * (kM / 2 * (change - std::log1p(change / 4)) +
                    kL0 / 2 * theta * (theta + 2 * (1 - kAlpha0))) +
             volumetric;
    }
    case MaterialLaw::kStVenantKirchhoff:
      return mu_ * GreenStrain(F).squaredNorm() + volumetric;
  }
  HPDM_CHECK(false);
}

Matrix3d HyperelasticLaw::Stress(const Matrix3d& F) const {
  const double theta = Dilatation(F);
  switch (law_) {
    case MaterialLaw::kNeoHookean: {
      const double shape = mu_ * kM * (1 - 1 / (F.squaredNorm() + 1));
      return shape * F + Pressure(theta) * JacobianGradient(F);
    }
    case MaterialLaw::kStVenantKirchhoff:
      return F * (2 * mu_ * GreenStrain(F) + lambda_ * theta * Matrix3d::Identity());
  }
  HPDM_CHECK(false);
}

Matrix9d HyperelasticLaw::Tangent(const Matrix3d& F) const {
  switch (law_) {
    case MaterialLaw::kNeoHookean:
      return NeoHookeanTangent(F);
    case MaterialLaw::kStVenantKirchhoff:
      return StVenantKirchhoffTangent(F);
  }
  HPDM_CHECK(false);
}

Matrix9d HyperelasticLaw::StVenantKirchhoffTangent(const Matrix3d& F) const {
  Matrix9d A;
  // P = F S: dP = dF S + F (2 mu dE + lambda tr(dE) I), with dE = sym(F^T dF).
  const Matrix3d S = 2 * mu_ * GreenStrain(F) + lambda_ * Dilatation(F) * Matrix3d::Identity();
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

Matrix9d HyperelasticLaw::NeoHookeanTangent(const Matrix3d& F) const {
  Matrix9d A;
  const double I_C = F.squaredNorm();
  const Matrix3d gradient = JacobianGradient(F);
  const Eigen::Map<const Vector9d> f(F.data()), g(gradient.data());
  A = (lambda_ + mu_ * kL0) * g * g.transpose() +
      mu_ * 2 * kM / ((I_C + 1) * (I_C + 1)) * f * f.transpose();
  A.diagonal().array() += mu_ * kM * (1 - 1 / (I_C + 1));
  AddDilatationHessian(F, Pressure(Dilatation(F)), &A);
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
