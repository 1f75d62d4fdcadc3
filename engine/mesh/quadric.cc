#include "engine/mesh/quadric.h"

namespace hpdm {

void Quadric::AddPlane(const Vector3d& normal, const Vector3d& point, double weight) {
  const double offset = normal.dot(point);
  a_ += weight * normal * normal.transpose();
  b_ += weight * offset * normal;
  c_ += weight * offset * offset;
  weight_ += weight;
}

Quadric& Quadric::operator+=(const Quadric& other) {
  a_ += other.a_;
  b_ += other.b_;
  c_ += other.c_;
  weight_ += other.weight_;
  return *this;
}

double Quadric::Error(const Vector3d& p) const {
  const Vector3d a_p = a_.col(0) * p[0] + a_.col(1) * p[1] + a_.col(2) * p[2];
  return p.dot(a_p) - 2 * b_.dot(p) + c_;
}

Vector3d Quadric::Minimiser(const Vector3d& anchor, double strength) const {
  const double pull = strength * weight_;
  const Vector3d x = a_.col(0) + pull * Vector3d::UnitX(), y = a_.col(1) + pull * Vector3d::UnitY(),
                 z = a_.col(2) + pull * Vector3d::UnitZ();
  const Vector3d right = b_ + pull * anchor;
  // Cramer's rule; the matrix is symmetric with eigenvalues of at least `pull`.
  const Vector3d y_z = y.cross(z);
  const double determinant = x.dot(y_z);
  if (!(determinant > 0)) return anchor;
  return Vector3d(right.dot(y_z), x.dot(right.cross(z)), x.dot(y.cross(right))) / determinant;
}

}  // namespace hpdm
