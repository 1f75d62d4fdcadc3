#include "tools/stress/viscous_energy.h"

#include <gtest/gtest.h>

#include "tools/stress/contact_energy.h"
#include "tools/stress/stress_cases.h"
#include "tools/stress/stress_touch_fixture.h"

namespace hpdm {
namespace {

constexpr double kShare = 0.6, kTime = 1;

// A tip of 2.5 mm pressed 5 mm deep within 10 ms and held; the tissue is stepped a hundred times a
// second.
struct Held {
  Held() {
    StressTouchFixture fixture = SoftOrgan(StressModel::kMetricSmall, true);
    fixture.organ.material.prony = {.count = 1, .terms = {{{kShare, kTime}}}};
    fixture.timing.deformation_hz = 100;
    const Vector3d top = fixture.Top(0.01, 0.004);
    StressSessionFixture body(fixture.organ, fixture.rest,
                              {OverOrgan({{0.2, Below(top, -1e-4)}, {0.21, Below(top, 0.005)}})},
                              fixture.timing);
    body.RunUntil(7, nullptr, &record);
    long_term = EnergyInOrgan(body.organ(), body.state());
  }
  ContactRecord record;
  double long_term = 0;  // J
};

// A held step of a Maxwell branch dissipates all that its spring held: r E with r = g / (1 - g).
TEST(ViscousEnergy, OfAHeldStepIsDissipatedInTheEnd) {
  const Held held;
  ASSERT_GT(held.long_term, 1e-5);
  const StoredEnergy& end = held.record.stored.back();
  EXPECT_NEAR(end.energy, held.long_term, 1e-3 * held.long_term);
  const double ratio = kShare / (1 - kShare);
  EXPECT_NEAR(end.dissipated, ratio * held.long_term, 0.03 * ratio * held.long_term);
}

// The work of the hand is stored or dissipated to a hundredth; without the dashpots a third of it
// would be missing.
TEST(ViscousEnergy, ClosesTheBalanceOfAPressAndOfAGrasp) {
  for (const char* name : {"viscous_press", "viscous_press_wide", "viscous_grasp"}) {
    for (const StressCase& each : TouchStress(true)) {
      if (each.name != name) continue;
      for (const double share : {0.3, 0.75}) {
        const StressTrial trial = each.run(StressModel::kStrainSmall, share);
        EXPECT_EQ(trial.fate, StressFate::kSurvived) << name << " " << share << ": " << trial.how;
        EXPECT_LT(trial.error.value_or(1), 0.004) << name << " " << share;
      }
    }
  }
}

TEST(ContactBalance, CountsWhatTheTissueDissipates) {
  // 1 mJ put in within 0.1 s and held: the tissue stores it, and then turns half of it to heat.
  std::vector<ContactTick> ticks(1);
  std::vector<StoredEnergy> stored;
  for (int i = 1; i <= 300; ++i) {
    ContactTick& tick = ticks.emplace_back();
    tick.kind = ContactKind::kPress;
    tick.p_tip_W = Vector3d(0, 0, -1e-5 * std::min(i, 100));
    tick.normal_W = Vector3d::UnitZ();
    tick.reaction_W = Vector3d::UnitZ();
    if (i % 30 != 0) continue;
    const double work = 1e-5 * std::min(i, 100), heat = 0.5 * std::max(0.0, 1e-3 * (i - 100) / 200);
    stored.push_back({static_cast<std::size_t>(i), work - heat, heat});
  }
  EXPECT_LT(BalancesOf(ticks, stored, 0).at(0).Error(), 0.01);
  EXPECT_NEAR(BalancesOf(ticks, stored, 0).at(0).dissipated, 5e-4, 1e-5);
  for (StoredEnergy& each : stored) each.dissipated *= 0.5;
  EXPECT_GT(BalancesOf(ticks, stored, 0).at(0).Error(), 0.2);
}

}  // namespace
}  // namespace hpdm
