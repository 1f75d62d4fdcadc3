#include "engine/step/quality_choice.h"

#include <gtest/gtest.h>

namespace hpdm {
namespace {

constexpr double kBound = 0.3;
constexpr double kSlope = 0.1;  // dE/ds over E
constexpr QualityCeiling kNothingShed;

OrganOptions ChoiceOptions(StrainMeasure strain) {
  OrganOptions options;
  options.energy.type = EnergyType::kStrain;
  options.energy.strain = strain;
  options.energy.finite_from = kBound;
  options.energy.newton_iterations = 4;
  options.lattice.local.functions = 4;
  return options;
}

class QualityChoiceTest : public testing::Test {
 protected:
  explicit QualityChoiceTest(StrainMeasure strain = StrainMeasure::kAdaptive)
      : choice_(ChoiceOptions(strain)) {}

  double Share(double gradient, const QualityCeiling& ceiling = kNothingShed, bool touched = true) {
    return choice_.Next(ceiling, touched, gradient, kSlope).finite_share;
  }
  // The share after as many steps as anything takes.
  double InTheEnd(double gradient, const QualityCeiling& ceiling = kNothingShed) {
    for (int step = 0; step < 1000; ++step) Share(gradient, ceiling);
    return Share(gradient, ceiling);
  }

  QualityChoice choice_;
};

class FiniteChoiceTest : public QualityChoiceTest {
 protected:
  FiniteChoiceTest() : QualityChoiceTest(StrainMeasure::kFinite) {}
};

TEST_F(QualityChoiceTest, AdaptiveStrainIsSmallBelowTheBoundAndFiniteBeyond) {
  EXPECT_EQ(InTheEnd(0.99 * kBound), 0);
  EXPECT_EQ(InTheEnd(1.01 * kBound), 1);
}

TEST_F(QualityChoiceTest, BetweenTheBoundsItStaysAsItIs) {
  const double between = 0.9 * kBound;
  EXPECT_EQ(InTheEnd(between), 0);
  InTheEnd(1.01 * kBound);
  EXPECT_EQ(InTheEnd(between), 1);
  EXPECT_EQ(InTheEnd(0.79 * kBound), 0);
}

TEST_F(QualityChoiceTest, AStepMovesTheForceByNoMoreThanItsShare) {
  double last = Share(1.01 * kBound);
  EXPECT_EQ(last, QualityChoice::kFirstStep);
  for (double share = 0; last < 1; last = share) {
    share = Share(1.01 * kBound);
    EXPECT_LE((share - last) * kSlope * QualityChoice::kForceOverEnergy,
              1.01 * QualityChoice::kForceStep * 1.01);  // 1.01: as far beyond the bound; round-off
  }
  while (last > 0) {
    const double share = Share(0);
    EXPECT_LE(last - share, QualityChoice::kForceStep / QualityChoice::kForceOverEnergy / kSlope +
                                1e-12);  // round-off
    last = share;
  }
}

TEST_F(QualityChoiceTest, FarBeyondTheBoundItHurriesWithinALimit) {
  Share(100 * kBound);
  const double last = Share(100 * kBound), next = Share(100 * kBound);
  EXPECT_NEAR((next - last) * kSlope * QualityChoice::kForceOverEnergy,
              QualityChoice::kMostForceStep, 1e-12);  // round-off
}

TEST_F(QualityChoiceTest, WithoutContactThereIsNothingToBeGradualAbout) {
  InTheEnd(2 * kBound);
  EXPECT_EQ(Share(2 * kBound, kNothingShed, false), 0);
}

TEST_F(QualityChoiceTest, ACeilingIsFollowedDownAndUpInSteps) {
  const QualityCeiling none{.halvings = 5, .finite = false, .local = false};
  InTheEnd(2 * kBound);
  OrganQuality last = choice_.Next(kNothingShed, true, 2 * kBound, kSlope);
  EXPECT_EQ(last.newton_iterations, 4);
  EXPECT_EQ(last.local_share, 1);
  EXPECT_TRUE(choice_.settled());
  for (int step = 0; step < 1000; ++step) {
    const OrganQuality next = choice_.Next(none, true, 2 * kBound, kSlope);
    EXPECT_EQ(next.newton_iterations, 1) << "one is always made";
    EXPECT_LE(last.local_share - next.local_share, QualityChoice::kLocalStep);
    EXPECT_EQ(choice_.settled(), next.finite_share == 0 && next.local_share == 0);
    last = next;
  }
  EXPECT_TRUE(choice_.settled());
  EXPECT_EQ(InTheEnd(2 * kBound), 1);
  EXPECT_EQ(choice_.Next(kNothingShed, true, 2 * kBound, kSlope).local_share, 1);
}

TEST_F(QualityChoiceTest, WhatAReplayTakesIsWhereItGoesOn) {
  choice_.Obey({.newton_iterations = 4, .finite_share = 0.5, .local_share = 0.25});
  const OrganQuality next = choice_.Next(kNothingShed, true, 2 * kBound, kSlope);
  EXPECT_GT(next.finite_share, 0.5);
  EXPECT_LT(next.finite_share, 0.6);
  EXPECT_EQ(next.local_share, 0.25 + QualityChoice::kLocalStep);
}

TEST_F(FiniteChoiceTest, FiniteStrainIsAlwaysWhole) {
  EXPECT_EQ(Share(0, kNothingShed, false), 1);
  EXPECT_EQ(Share(0), 1);
  EXPECT_EQ(Share(10 * kBound), 1);
}

}  // namespace
}  // namespace hpdm
