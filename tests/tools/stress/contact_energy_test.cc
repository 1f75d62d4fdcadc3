#include "tools/stress/contact_energy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tools/stress/stress_cases.h"
#include "tools/stress/stress_touch_fixture.h"

namespace hpdm {
namespace {

constexpr double kSpring = 200;  // N/m
constexpr double kDeepest = 0.01;
constexpr int kTicks = 1001;
constexpr std::size_t kStep = 33;  // ticks

// A tip pressed straight into a spring and withdrawn; it feels `back` times the spring's force on the
// way out.
struct SpringPress {
  explicit SpringPress(double back = 1) {
    for (int i = 0; i < kTicks; ++i) {
      const double depth = kDeepest * (1 - std::abs(i - 500) / 450.);
      const double force = kSpring * std::max(depth, 0.0) * (i > 500 ? back : 1);
      ContactTick& tick = ticks.emplace_back();
      tick.p_tip_W = Vector3d(0, 0, -depth);
      if (depth <= 0) continue;
      tick.kind = ContactKind::kPress;
      tick.normal_W = Vector3d::UnitZ();
      tick.reaction_W = tick.force_W = Vector3d(0, 0, force);
      if (ticks.size() % kStep == 0) {
        stored.push_back({ticks.size() - 1, 0.5 * kSpring * depth * depth});
      }
    }
  }
  ContactBalance Balance(double tip_radius = 0) const {
    const std::vector<ContactBalance> balances = BalancesOf(ticks, stored, tip_radius);
    EXPECT_EQ(balances.size(), 1u);
    return balances.empty() ? ContactBalance() : balances[0];
  }

  std::vector<ContactTick> ticks;
  std::vector<StoredEnergy> stored;
};

TEST(ContactBalance, OfASpringIsClosed) {
  const ContactBalance balance = SpringPress().Balance();
  EXPECT_GT(balance.judged, 20);
  EXPECT_NEAR(balance.put_in, 0.5 * kSpring * kDeepest * kDeepest, 1e-6);
  EXPECT_NEAR(balance.work, 0, 1e-12);
  EXPECT_LT(balance.Error(), 1e-4);
}

TEST(ContactBalance, FlagsAContactThatGivesTheHandEnergy) {
  const ContactBalance balance = SpringPress(1.03).Balance();
  EXPECT_NEAR(balance.Error(), 0.03, 1e-3);
  EXPECT_LT(balance.unexplained, 0) << "the hand got it";
}

TEST(ContactBalance, FlagsEnergyThatVanishes) {
  const ContactBalance balance = SpringPress(0.97).Balance();
  EXPECT_NEAR(balance.Error(), 0.03, 1e-3);
  EXPECT_GT(balance.unexplained, 0);
}

TEST(ContactBalance, FlagsAForceThatIsNotTheOrgans) {
  SpringPress press;
  for (StoredEnergy& stored : press.stored) stored.energy *= 1.05;
  EXPECT_NEAR(press.Balance().Error(), 0.05, 0.005);
}

TEST(ContactBalance, ListsTheGuardsPartButJudgesTheRawForce) {
  SpringPress press(1.03);
  for (ContactTick& tick : press.ticks) tick.force_W = 0.5 * tick.reaction_W;
  const ContactBalance balance = press.Balance();
  EXPECT_NEAR(balance.Error(), 0.03, 1e-3) << "a guard hides no fault";
  EXPECT_NEAR(balance.guard, -0.5 * balance.work, 1e-12);
}

// A tip under a constant force that is dragged over stiff tissue. All work is friction's.
TEST(ContactBalance, CountsTheSlipAsFriction) {
  std::vector<ContactTick> ticks(1);
  std::vector<StoredEnergy> stored;
  for (int i = 1; i <= 300; ++i) {
    ticks.push_back({.kind = ContactKind::kPress,
                     .p_tip_W = 1e-4 * i * Vector3d::UnitX(),
                     .reaction_W = Vector3d(-0.3, 0, 1),
                     .normal_W = Vector3d::UnitZ(),
                     .friction_W = 0.3 * Vector3d::UnitX(),
                     .slip_W = 1e-4 * Vector3d::UnitX()});
    if (i % 30 == 0) stored.push_back({static_cast<std::size_t>(i), 0});
  }
  const ContactBalance slides = BalancesOf(ticks, stored, 0.005).at(0);
  EXPECT_NEAR(slides.friction, 0.3 * 0.03, 1e-4);
  EXPECT_LT(slides.Error(), 0.01);
  for (ContactTick& tick : ticks) tick.slip_W.setZero();
  EXPECT_GT(BalancesOf(ticks, stored, 0.005).at(0).Error(), 0.9) << "it sticks but dissipates";
}

TEST(ContactBalance, OfAGraspStartsAtWhatThePressHadStored) {
  SpringPress press;
  for (std::size_t i = 400; i < press.ticks.size(); ++i) {
    if (press.ticks[i].kind != ContactKind::kNone) press.ticks[i].kind = ContactKind::kGrasp;
  }
  const std::vector<ContactBalance> balances = BalancesOf(press.ticks, press.stored, 0);
  ASSERT_EQ(balances.size(), 2u);
  EXPECT_EQ(balances[1].kind, ContactKind::kGrasp);
  EXPECT_LT(balances[0].Error(), 1e-3);
  EXPECT_LT(balances[1].Error(), 1e-3);
}

TEST(LargestTurn, IsTheAngleBetweenTheTwoFarthestForces) {
  const auto at = [](double degrees) {
    const double angle = degrees * std::numbers::pi / 180;
    return Vector3d(std::sin(angle), 0, std::cos(angle));
  };
  const std::vector<Vector3d> forces = {at(0), 2 * at(3), at(-4), 1e-3 * at(90)};
  EXPECT_NEAR(LargestTurn(forces, 0.01) * 180 / std::numbers::pi, 7, 1e-9);
}

TEST(RmsSpeed, OfACircleIsItsSpeed) {
  std::vector<Vector3d> points;
  for (int i = 0; i < 100; ++i) {
    points.emplace_back(1e-3 * std::cos(0.01 * i), 1e-3 * std::sin(0.01 * i), 0);
  }
  EXPECT_NEAR(RmsSpeed(points, 1e-3), 0.01, 1e-5);
}

// A tip pressed `depth` (m) deep into a soft organ's top, from just above it.
struct Pressed {
  double energy = 0;
  Vector3d way_W, force_W;  // of the contact's point from rest, and on the tissue
};
Pressed PressTo(StressModel model, double depth) {
  const StressTouchFixture fixture = SoftOrgan(model, true);
  const Vector3d top = fixture.Top(0.01, 0.004);
  StressSessionFixture body(fixture.organ, fixture.rest,
                            {OverOrgan({{0.2, Below(top, -0.01)}, {0.4, Below(top, depth)}})});
  body.RunUntil(0.8);
  const ContactConstraints& rows = body.state().contacts;
  EXPECT_EQ(rows.size(), 1);
  return {EnergyInOrgan(body.organ(), body.state()),
          body.step().contacts[0].contact_W - rows[0].p_rest_W, rows[0].force_W};
}

// Clapeyron: the energy of a linear organ is half of the force times the way of its point.
TEST(EnergyInOrgan, IsHalfTheForceTimesTheWayWithoutALocalLaw) {
  const Pressed at = PressTo(StressModel::kMetricSmall, 0.005);
  const double expected = 0.5 * at.force_W.dot(at.way_W);
  EXPECT_GT(expected, 1e-5);
  EXPECT_NEAR(at.energy, expected, 1e-3 * expected);
}

// Under a ball the force is not linear in the depth; its work over a little way still is the energy.
TEST(EnergyInOrgan, RisesByTheWorkOfTheForce) {
  const Pressed less = PressTo(StressModel::kStrainSmall, 0.0048);
  const Pressed more = PressTo(StressModel::kStrainSmall, 0.0052);
  const double work = 0.5 * (less.force_W + more.force_W).dot(more.way_W - less.way_W);
  EXPECT_GT(work, 1e-6);
  EXPECT_NEAR(more.energy - less.energy, work, 0.01 * work);
}

TEST(FaultBeforeGuard, FailsATrialWhoseDisplayedForceIsSafe) {
  const double most = ForceGuardOptions().max_force;
  EXPECT_EQ(FaultBeforeGuard({.tissue_force = 1, .reaction = most, .force = most}), "");
  EXPECT_EQ(FaultBeforeGuard({.tissue_force = most, .reaction = 1.1 * most, .force = most}), "")
      << "the organ resists so much";
  EXPECT_NE(FaultBeforeGuard({.reaction_change = 1.1, .force_change = 1}), "");
  StressTrial trial;
  AddFaults({.tissue_force = 1, .reaction = 1.1 * most, .force = most}, 1e9, &trial);
  EXPECT_EQ(trial.fate, StressFate::kFailed);
  EXPECT_EQ(trial.harm, "");
}

// The work of a press, of a slide over the facets and of a rub is in the organ or dissipated to half
// of a hundredth, with any tip and at any speed: at rest on a flat triangle, or with a frame of the
// indentation that turns for nothing, a slide would lose 2.3 % and a rub 1.3 %.
TEST(TouchStress, ATouchLosesNoEnergy) {
  const auto lost = [](const std::string& name, double parameter) {
    double error = 1;
    for (const StressCase& each : TouchStress(true)) {
      if (each.name != name) continue;
      const StressTrial trial = each.run(StressModel::kStrainSmall, parameter);
      EXPECT_EQ(trial.fate, StressFate::kSurvived) << name << " " << parameter << ": " << trial.how;
      error = trial.error.value_or(1);
    }
    return error;
  };
  for (const double radius : {2.5, 10.}) {
    EXPECT_LT(lost("press_energy", radius), 0.002);
    EXPECT_LT(lost("slide_energy", radius), 0.003);
  }
  for (const double speed : {0.01, 0.05}) EXPECT_LT(lost("rub_energy", speed), 0.005);
}

}  // namespace
}  // namespace hpdm
