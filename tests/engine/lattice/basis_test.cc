#include "engine/lattice/basis.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace hpdm {
namespace {

std::vector<UnivariateBasis> AllBases() {
  std::vector<UnivariateBasis> bases;
  for (int degree = 1; degree <= 3; ++degree) {
    for (int cells : {1, 2, 5}) bases.emplace_back(BasisType::kBSpline, degree, cells);
  }
  for (int degree : {1, 2, 3, 7, 20}) bases.emplace_back(BasisType::kBernstein, degree, 1);
  return bases;
}

TEST(Basis, IsAPartitionOfUnityWithoutNegativeValues) {
  std::mt19937 random(1);
  for (const UnivariateBasis& basis : AllBases()) {
    std::vector<double> values(basis.support());
    for (int trial = 0; trial < 200; ++trial) {
      const double c = trial < 2 ? trial : random() / 4294967296.0;
      basis.Evaluate(c, values.data());
      double sum = 0;
      for (double value : values) {
        EXPECT_GE(value, 0);
        sum += value;
      }
      EXPECT_NEAR(sum, 1, 1e-14);  // round-off of up to 21 terms
    }
  }
}

TEST(Basis, GrevilleAbscissaeReproduceTheCoordinate) {
  for (const UnivariateBasis& basis : AllBases()) {
    std::vector<double> values(basis.support());
    for (double c = 0; c <= 1; c += 0.01) {
      const int first = basis.Evaluate(c, values.data());
      double x = 0;
      for (int i = 0; i < basis.support(); ++i) x += basis.Greville(first + i) * values[i];
      EXPECT_NEAR(x, c, 1e-14);
    }
  }
}

TEST(Basis, DerivativeBasisGivesTheDerivative) {
  std::mt19937 random(2);
  for (const UnivariateBasis& basis : AllBases()) {
    const UnivariateBasis derivative = basis.DerivativeBasis();
    std::vector<double> control(basis.count());
    for (double& value : control) value = random() / 4294967296.0;
    std::vector<double> values(basis.support());
    const auto curve = [&](double c) {
      const int first = basis.Evaluate(c, values.data());
      double sum = 0;
      for (int i = 0; i < basis.support(); ++i) sum += control[first + i] * values[i];
      return sum;
    };
    for (double c : {0.111, 0.357, 0.729}) {  // inside the cells of every basis above
      const int first = derivative.Evaluate(c, values.data());
      double slope = 0;
      for (int i = 0; i < derivative.support(); ++i) {
        slope += (control[first + i + 1] - control[first + i]) / basis.spacing() * values[i];
      }
      const double step = 1e-6;
      // Central difference: error of order step^2 times the third derivative (up to 20^3) plus
      // round-off / step.
      EXPECT_NEAR(slope, (curve(c + step) - curve(c - step)) / (2 * step), 1e-7);
    }
  }
}

TEST(Basis, BernsteinPolynomialsOfDegreeThreeMatchTheirFormulas) {
  const UnivariateBasis basis(BasisType::kBernstein, 3, 1);
  double values[4];
  basis.Evaluate(0.25, values);
  const double expected[4] = {27 / 64.0, 27 / 64.0, 9 / 64.0, 1 / 64.0};
  for (int i = 0; i < 4; ++i) EXPECT_DOUBLE_EQ(values[i], expected[i]);
}

}  // namespace
}  // namespace hpdm
