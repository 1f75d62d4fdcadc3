#include "scenes/generator/shapes/solid_noise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace hpdm {
namespace {

TEST(SolidNoise, RandomNumbersAreThePublishedSequence) {
  // The first numbers of the authors' generator from seed 1234567.
  RandomNumbers random(1234567);
  EXPECT_EQ(random.Next(), 6457827717110365317u);
  EXPECT_EQ(random.Next(), 3203168211198807973u);
}

TEST(SolidNoise, GradientNoiseIsSmoothBalancedAndZeroOnItsLattice) {
  EXPECT_EQ(GradientNoise(Vector3d(3, -7, 12), 1), 0);
  RandomNumbers random(1);
  double sum = 0, squares = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vector3d p = 40 * Vector3d(random.Fraction(), random.Fraction(), random.Fraction());
    const double noise = GradientNoise(p, 1);
    sum += noise;
    squares += noise * noise;
    ASSERT_LT(std::abs(noise), 1.05);
    // No steps, at lattice planes either: the slope is a few at most.
    const Vector3d beside(std::round(p.x()) + 1e-7, p.y(), p.z());
    const Vector3d before(std::round(p.x()) - 1e-7, p.y(), p.z());
    ASSERT_NEAR(GradientNoise(beside, 1), GradientNoise(before, 1), 1e-6);
  }
  EXPECT_NEAR(sum / 20000, 0, 0.01);  // three standard errors of 0.28 / sqrt(20000)
  EXPECT_GT(squares / 20000, 0.04);
}

TEST(SolidNoise, CellsKnowTheirTwoNearestPoints) {
  RandomNumbers random(2);
  for (int i = 0; i < 2000; ++i) {
    const Vector3d p = 20 * Vector3d(random.Fraction(), random.Fraction(), random.Fraction());
    const CellSample cell = CellNoise(p, 4), beside = CellNoise(p + Vector3d(0.01, 0, 0), 4);
    ASSERT_LE(cell.nearest, cell.second);
    // A point lies in every unit cube: none is farther than the diagonal of two.
    ASSERT_LT(cell.nearest, std::sqrt(3.0));
    // Distances change by no more than the step.
    ASSERT_LE(std::abs(beside.nearest - cell.nearest), 0.01 + 1e-12);
    ASSERT_TRUE(cell.shade >= 0 && cell.shade < 1);
  }
}

}  // namespace
}  // namespace hpdm
