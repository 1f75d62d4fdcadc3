#include "engine/reference_fem/tetra_fem.h"

#include <Eigen/LU>
#include <cmath>

namespace hpdm {
namespace {

using ShapeGradients = Eigen::Matrix<double, Eigen::Dynamic, 3>;

/// Returns the gradients of the shape functions at barycentric coordinates, from the coordinates'
/// gradients.
ShapeGradients GradientsAt(bool quadratic, const Eigen::Vector4d& barycentric,
                           const Eigen::Matrix<double, 4, 3>& gradients) {
  if (!quadratic) return gradients;
  ShapeGradients dN(10, 3);
  for (int k = 0; k < 4; ++k) dN.row(k) = (4 * barycentric[k] - 1) * gradients.row(k);
  for (int k = 0; k < 6; ++k) {
    const auto [a, b] = kTetraEdges[static_cast<std::size_t>(k)];
    dN.row(4 + k) = 4 * (barycentric[a] * gradients.row(b) + barycentric[b] * gradients.row(a));
  }
  return dN;
}

// The four-point rule of degree two (Hammer and Stroud 1956): (5 -+ sqrt 5) / 20.
constexpr double kFar = 0.13819660112501052, kNear = 0.58541019662496845;

}  // namespace

TetraBody::TetraBody(TetraMesh mesh, const MaterialOptions& material, TetraLaw law,
                     const Eigen::VectorXd& stiffness)
    : mesh_(std::move(mesh)), options_(material), material_(material, law) {
  for (Eigen::Index e = 0; e < mesh_.elements.rows(); ++e) {
    const Matrix3d edges = CornerEdges(mesh_, e);
    Element element;
    element.volume = edges.determinant() / 6;
    element.stiffness = stiffness.size() > 0 ? stiffness[e] : 1;
    element.gradients.bottomRows(3) = edges.inverse();
    element.gradients.row(0) = -element.gradients.bottomRows(3).colwise().sum();
    elements_.push_back(element);
  }
}

template <typename Visit>
void TetraBody::ForEachPoint(const Visit& visit) const {
  const int points = mesh_.quadratic() ? 4 : 1;
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    for (int q = 0; q < points; ++q) {
      Eigen::Vector4d barycentric = Eigen::Vector4d::Constant(points == 1 ? 0.25 : kFar);
      if (points == 4) barycentric[q] = kNear;
      visit(static_cast<Eigen::Index>(e),
            GradientsAt(mesh_.quadratic(), barycentric, elements_[e].gradients),
            elements_[e].volume / points);
    }
  }
}

Matrix3d TetraBody::DeformationGradient(Eigen::Index e, const ShapeGradients& dN,
                                        const Points& u) const {
  Matrix3d F = Matrix3d::Identity();
  for (Eigen::Index a = 0; a < dN.rows(); ++a) {
    F.noalias() += u.row(mesh_.elements(e, a)).transpose() * dN.row(a);
  }
  return F;
}

double TetraBody::Energy(const Points& u) const {
  const double at_rest = material_.Density(Matrix3d::Identity());
  double energy = 0;
  ForEachPoint([&](Eigen::Index e, const ShapeGradients& dN, double weight) {
    energy += weight * Stiffness(e) * (material_.Density(DeformationGradient(e, dN, u)) - at_rest);
  });
  return energy;
}

Points TetraBody::Gradient(const Points& u) const {
  Points gradient = Points::Zero(u.rows(), 3);
  ForEachPoint([&](Eigen::Index e, const ShapeGradients& dN, double weight) {
    const Matrix3d P = weight * Stiffness(e) * material_.Stress(DeformationGradient(e, dN, u));
    for (Eigen::Index a = 0; a < dN.rows(); ++a) {
      gradient.row(mesh_.elements(e, a)) += dN.row(a) * P.transpose();
    }
  });
  return gradient;
}

void TetraBody::SetHessian(const Points& u, bool convex, BlockMatrix* K) const {
  K->SetZero();
  ForEachPoint([&](Eigen::Index e, const ShapeGradients& dN, double weight) {
    const Matrix9d C =
        weight * Stiffness(e) * material_.Tangent(DeformationGradient(e, dN, u), convex);
    for (Eigen::Index b = 0; b < dN.rows(); ++b) {
      Eigen::Matrix<double, 9, 3> Cb = Eigen::Matrix<double, 9, 3>::Zero();
      for (int l = 0; l < 3; ++l) Cb += C.middleCols<3>(3 * l) * dN(b, l);
      for (Eigen::Index a = 0; a < dN.rows(); ++a) {
        Matrix3d block = Matrix3d::Zero();
        for (int j = 0; j < 3; ++j) block += dN(a, j) * Cb.middleRows<3>(3 * j);
        K->At(mesh_.elements(e, a), mesh_.elements(e, b)) += block;
      }
    }
  });
}

double TetraBody::VolumeChange(const Points& u) const {
  double change = 0, volume = 0;
  ForEachPoint([&](Eigen::Index e, const ShapeGradients& dN, double weight) {
    const Matrix3d F = DeformationGradient(e, dN, u);
    change += weight * (law() == TetraLaw::kSmallStrain ? F.trace() - 3 : F.determinant() - 1);
    volume += weight;
  });
  return change / volume;
}

}  // namespace hpdm
