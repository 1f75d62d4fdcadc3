#include "engine/solver/secant_memory.h"

namespace hpdm {
namespace {

// Least s . y over y . H0 y. In a direction a thousand times as stiff as H0 knows, or not convex,
// the pair would make H nearly singular.
constexpr double kLeastCurvature = 1e-3;

}  // namespace

SecantMemory::SecantMemory(Eigen::Index unknowns, int most)
    : s_(unknowns, most),
      y_(unknowns, most),
      H0_y_(unknowns, most),
      inverse_(most),
      v_(unknowns),
      along_(most) {}

void SecantMemory::Add(const Eigen::Ref<const Eigen::VectorXd>& s,
                       const Eigen::Ref<const Eigen::VectorXd>& y,
                       const Eigen::Ref<const Eigen::VectorXd>& H0_y) {
  const double curvature = s.dot(y);
  if (!(curvature > kLeastCurvature * y.dot(H0_y)) || !(curvature > 0)) return;
  if (count_ == s_.cols()) {
    first_ = Place(1);
  } else {
    ++count_;
  }
  const int place = Place(count_ - 1);
  s_.col(place) = s;
  y_.col(place) = y;
  H0_y_.col(place) = H0_y;
  inverse_[place] = 1 / curvature;
}

void SecantMemory::ForgetRow(int row) {
  for (int age = 0; age < count_; ++age) {
    const int i = Place(age);
    for (Eigen::MatrixXd* part : {&s_, &y_, &H0_y_}) part->col(i).segment<3>(3 * row).setZero();
    const double curvature = s_.col(i).dot(y_.col(i));
    if (!(curvature > 0)) {
      Clear();
      return;
    }
    inverse_[i] = 1 / curvature;
  }
}

void SecantMemory::Apply(const Eigen::Ref<const Eigen::VectorXd>& v,
                         Eigen::Ref<Eigen::VectorXd> response) const {
  v_ = v;
  for (int age = count_ - 1; age >= 0; --age) {
    const int i = Place(age);
    along_[i] = inverse_[i] * s_.col(i).dot(v_);
    v_ -= along_[i] * y_.col(i);
    response -= along_[i] * H0_y_.col(i);
  }
  for (int age = 0; age < count_; ++age) {
    const int i = Place(age);
    response += (along_[i] - inverse_[i] * y_.col(i).dot(response)) * s_.col(i);
  }
}

}  // namespace hpdm
