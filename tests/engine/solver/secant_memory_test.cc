#include "engine/solver/secant_memory.h"

#include <gtest/gtest.h>

#include <cstdlib>

namespace hpdm {
namespace {

constexpr Eigen::Index kUnknowns = 12;

// A quadratic energy with the Hessian `K` and the first approximation `H0` of its inverse.
class SecantMemoryTest : public testing::Test {
 protected:
  static Eigen::MatrixXd PositiveDefinite(unsigned seed) {
    std::srand(seed);
    const Eigen::MatrixXd A = Eigen::MatrixXd::Random(kUnknowns, kUnknowns);
    return A * A.transpose() + Eigen::MatrixXd::Identity(kUnknowns, kUnknowns);
  }
  void AddStep(const Eigen::VectorXd& s) {
    const Eigen::VectorXd y = K_ * s;
    memory_.Add(s, y, H0_ * y);
  }
  Eigen::VectorXd Apply(const Eigen::VectorXd& v) const {
    Eigen::VectorXd response = H0_ * v;
    memory_.Apply(v, response);
    return response;
  }

  Eigen::MatrixXd K_ = PositiveDefinite(1), H0_ = PositiveDefinite(2);
  SecantMemory memory_{kUnknowns, 4};
};

TEST_F(SecantMemoryTest, MapsTheLastChangeOfTheGradientToItsStep) {
  EXPECT_EQ(Apply(Eigen::VectorXd::Ones(kUnknowns)), H0_ * Eigen::VectorXd::Ones(kUnknowns));
  for (int step = 0; step < 7; ++step) {  // beyond its room
    const Eigen::VectorXd s = Eigen::VectorXd::Random(kUnknowns);
    AddStep(s);
    EXPECT_LT((Apply(K_ * s) - s).norm(), 1e-10 * s.norm()) << step;  // rounding
  }
  EXPECT_EQ(memory_.size(), 4);
}

TEST_F(SecantMemoryTest, StaysSymmetricAndPositive) {
  for (int step = 0; step < 4; ++step) AddStep(Eigen::VectorXd::Random(kUnknowns));
  const Eigen::VectorXd u = Eigen::VectorXd::Random(kUnknowns);
  const Eigen::VectorXd v = Eigen::VectorXd::Random(kUnknowns);
  EXPECT_NEAR(u.dot(Apply(v)) / v.dot(Apply(u)), 1, 1e-10);  // rounding
  EXPECT_GT(v.dot(Apply(v)), 0);
}

TEST_F(SecantMemoryTest, IgnoresStepsAlongWhichTheEnergyIsNotConvex) {
  const Eigen::VectorXd s = Eigen::VectorXd::Ones(kUnknowns), y = -s;
  memory_.Add(s, y, H0_ * y);
  EXPECT_EQ(memory_.size(), 0);
}

TEST_F(SecantMemoryTest, ForgetsARowThatStandsForAnotherFunction) {
  AddStep(Eigen::VectorXd::Random(kUnknowns));
  memory_.ForgetRow(1);
  const Eigen::VectorXd v = Eigen::VectorXd::Random(kUnknowns);
  const Eigen::VectorXd remembered = Apply(v) - H0_ * v;
  EXPECT_EQ(remembered.segment<3>(3).norm(), 0);
  EXPECT_GT(remembered.norm(), 0);
}

}  // namespace
}  // namespace hpdm
