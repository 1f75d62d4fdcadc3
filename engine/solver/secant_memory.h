#pragma once

#include <Eigen/Core>

namespace hpdm {

/// An approximation H of the inverse Hessian of an energy from its last gradients, beside a first
/// approximation H0 that the caller applies (L-BFGS; Nocedal 1980). H maps the change of the gradient
/// of each remembered step to that step. One thread; allocates nothing once built.
class SecantMemory {
 public:
  SecantMemory(Eigen::Index unknowns, int most);

  void Clear() { count_ = 0; }
  int size() const { return count_; }

  /// Remembers that the gradient changed by y over the step s, and H0 y. Forgets the oldest such pair
  /// if there is no room. Ignores a pair along which the energy is hardly convex, measured by H0.
  void Add(const Eigen::Ref<const Eigen::VectorXd>& s, const Eigen::Ref<const Eigen::VectorXd>& y,
           const Eigen::Ref<const Eigen::VectorXd>& H0_y);

  /// Forgets what is known of the three unknowns of a row of U: they now stand for another function.
  void ForgetRow(int row);

  /// Replaces `response`, which is H0 v, by H v.
  void Apply(const Eigen::Ref<const Eigen::VectorXd>& v,
             Eigen::Ref<Eigen::VectorXd> response) const;

 private:
  int Place(int age) const { return (first_ + age) % static_cast<int>(s_.cols()); }

  int count_ = 0, first_ = 0;     // the oldest pair is at first_
  Eigen::MatrixXd s_, y_, H0_y_;  // unknowns x most
  Eigen::VectorXd inverse_;       // most: 1 / s . y
  mutable Eigen::VectorXd v_, along_;
};

}  // namespace hpdm
