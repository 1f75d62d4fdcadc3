#include "engine/step/load_shedding.h"

#include <gtest/gtest.h>

namespace hpdm {
namespace {

constexpr Nanoseconds kStepPeriod = kNanosecondsPerSecond / 30;
constexpr Nanoseconds kBudget = 20'000'000;

constexpr Sheddable kAll{.newton_iterations = 12, .finite = true, .refinement = true};

class LoadSheddingTest : public testing::Test {
 protected:
  void Step(Nanoseconds compute, bool settled = true) {
    shedding_.Observe(now_, compute, settled);
    now_ += kStepPeriod;
  }
  void Steps(int count, Nanoseconds compute) {
    for (int i = 0; i < count; ++i) Step(compute);
  }

  LoadShedding shedding_{kAll, kBudget};
  Nanoseconds now_ = 0;
};

TEST_F(LoadSheddingTest, QualityFallsInItsOrder) {
  ASSERT_EQ(shedding_.levels(), 4);
  const QualityCeiling order[] = {
      {0, true, true}, {1, true, true}, {2, true, true}, {2, false, true}, {2, false, false}};
  for (int level = 0; level <= 4; ++level) {
    const QualityCeiling ceiling = shedding_.Ceiling();
    EXPECT_EQ(shedding_.level(), level);
    EXPECT_EQ(ceiling.halvings, order[level].halvings) << level;
    EXPECT_EQ(ceiling.finite, order[level].finite) << level;
    EXPECT_EQ(ceiling.refinement, order[level].refinement) << level;
    Steps(LoadShedding::kTooMany, kBudget + 1);
  }
  Steps(10, 10 * kBudget);
  EXPECT_EQ(shedding_.level(), 4) << "there is no more to shed";
}

TEST_F(LoadSheddingTest, OneLongStepShedsNothing) {
  for (int i = 0; i < 50; ++i) {
    Step(3 * kBudget);
    Step(kBudget);
  }
  EXPECT_EQ(shedding_.level(), 0);
}

TEST_F(LoadSheddingTest, TheNextLevelWaitsUntilTheLastIsReached) {
  Steps(LoadShedding::kTooMany, 2 * kBudget);
  for (int i = 0; i < 20; ++i) Step(2 * kBudget, false);
  EXPECT_EQ(shedding_.level(), 1);
  Step(2 * kBudget);
  EXPECT_EQ(shedding_.level(), 2);
}

TEST_F(LoadSheddingTest, BetweenEaseAndBudgetItStays) {
  Steps(LoadShedding::kTooMany, 2 * kBudget);
  Steps(10'000, kBudget * 9 / 10);
  EXPECT_EQ(shedding_.level(), 1);
}

TEST_F(LoadSheddingTest, WithTimeToSpareItRisesLevelByLevel) {
  Steps(4 * LoadShedding::kTooMany, 2 * kBudget);
  ASSERT_EQ(shedding_.level(), 4);
  for (int level = 3; level >= 0; --level) {
    const Nanoseconds from = now_;
    while (shedding_.level() > level) Step(kBudget / 4);
    EXPECT_GE(now_ - from, LoadShedding::kWait);
    EXPECT_LE(now_ - from, LoadShedding::kWait + 3 * kStepPeriod);
  }
}

// Shed work frees the time that raises quality again: it is retried ever more rarely and does not
// oscillate.
TEST_F(LoadSheddingTest, ALoadThatLastsIsTriedEverMoreRarely) {
  int changes = 0;
  for (int i = 0; i < 30 * 600; ++i) {  // ten minutes
    const int before = shedding_.level();
    Step(shedding_.level() > 0 ? kBudget / 4 : 2 * kBudget);
    changes += shedding_.level() != before;
  }
  // Waits of 1, 2, 4, .. 64, 64, .. s: 6 + (600 - 63) / 64 times up and down.
  EXPECT_LE(changes, 2 * 15);
  EXPECT_GE(changes, 2 * 10) << "it does try";
}

TEST_F(LoadSheddingTest, WithoutABudgetNothingIsShed) {
  LoadShedding shedding(kAll, 0);
  for (int i = 0; i < 100; ++i) shedding.Observe(i * kStepPeriod, kNanosecondsPerSecond, true);
  EXPECT_EQ(shedding.level(), 0);
}

TEST(LoadShedding, ShedsOnlyExistingFeatures) {
  OrganOptions plain;
  plain.energy.type = EnergyType::kStrain;
  plain.lattice.local.functions = 0;
  OrganOptions refined = plain, finite = plain;
  refined.lattice.local.functions = 4;
  finite.energy.strain = StrainMeasure::kAdaptive;
  EXPECT_EQ(LoadShedding(SheddableOf({plain}), kBudget).levels(), 0);
  // 24 iterations are halved to three, then finite strain and local functions are left out.
  EXPECT_EQ(LoadShedding(SheddableOf({finite}), kBudget).levels(), 4);
  EXPECT_EQ(LoadShedding(SheddableOf({refined, finite}), kBudget).levels(), 5);

  LoadShedding shedding(SheddableOf({refined}), kBudget);
  for (int i = 0; i < 4; ++i) shedding.Observe(i * kStepPeriod, 2 * kBudget, true);
  EXPECT_EQ(shedding.level(), 1);
  EXPECT_FALSE(shedding.Ceiling().refinement);
}

}  // namespace
}  // namespace hpdm
