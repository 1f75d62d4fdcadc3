#include "haptics/safety/stability.h"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <vector>

namespace hpdm {
namespace {

using State = Eigen::Vector2d;

// Runge and Kutta's fourth-order rule in steps that leave its error below 1e-10 of the state.
State Integrate(const AxisDynamics& axis, State s, double force, double t) {
  const auto rate = [&](const State& at) {
    return State(at[1], (force - axis.damping * at[1] - axis.stiffness * at[0]) / axis.mass);
  };
  const int steps = 4000;
  const double h = t / steps;
  for (int i = 0; i < steps; ++i) {
    const State a = rate(s), b = rate(s + h / 2 * a), c = rate(s + h / 2 * b), d = rate(s + h * c);
    s += h / 6 * (a + 2 * b + 2 * c + d);
  }
  return s;
}

TEST(Stability, HeldForceStepSolvesTheAxisEquation) {
  const double m = 0.1;
  const AxisDynamics cases[] = {
      {m, 0.5, 0},                       // a device alone
      {m, 6.5, 300},                     // in a hand: overdamped
      {m, 0.5, 3000},                    // oscillating
      {m, 2 * std::sqrt(m * 250), 250},  // critical
      {m, 0, 0},
      {m, 0, 700},
      {m, 1e-9, 1e-9},
      {m, 50, 1e-6},
  };
  for (const AxisDynamics& axis : cases) {
    for (const double t : {2.5e-4, 4e-3, 0.1}) {
      const HeldForceStep step = ExactStep(axis, t);
      const State start(0.003, -0.2);
      const State exact = step.transition * start + 1.7 * step.input;
      const State reference = Integrate(axis, start, 1.7, t);
      // 1e-9 of a move of 0.2 m/s or 1.7 N over that time; the reference's own error is below it.
      const double scale = 0.2 + 17 * t;
      EXPECT_NEAR(exact[0], reference[0], 1e-9 * scale * t) << axis.damping << ' ' << t;
      EXPECT_NEAR(exact[1], reference[1], 1e-9 * scale) << axis.damping << ' ' << t;
    }
  }
}

TEST(Stability, LongHoldsEndWhereForceAndSpringBalance) {
  const HeldForceStep step = ExactStep({0.1, 60, 40}, 1e4);  // cosh alone would overflow
  EXPECT_NEAR(step.input[0], 1.0 / 40, 1e-12);
  EXPECT_NEAR(step.input[1], 0, 1e-12);
}

// Values computed independently to four digits; the project promises 2 %.
TEST(Stability, LimitIsThatOfTheExactDiscreteRoots) {
  const AxisDynamics device{0.1, 0.5};
  EXPECT_NEAR(StabilityLimit(device, 1e-3, 0), 1000.8, 0.05);
  EXPECT_NEAR(StabilityLimit(device, 1e-3, 1e-3), 333.8, 0.05);
}

// Simulates the loop in time. Returns the largest |x| in the last tenth over that in the tenth
// before the middle. The spring's force is commanded every 20 sub-steps and acts `delay` sub-steps
// later.
double Growth(const AxisDynamics& axis, double stiffness, double period, int delay) {
  constexpr int kSubsteps = 20;
  const HeldForceStep step = ExactStep(axis, period / kSubsteps);
  std::deque<double> commands(static_cast<std::size_t>(delay), 0.0);
  State s(0, 1);
  double command = 0, middle = 0, end = 0;
  const int count = 4000 * kSubsteps;
  for (int i = 0; i < count; ++i) {
    if (i % kSubsteps == 0) command = -stiffness * s[0];
    commands.push_back(command);
    s = step.transition * s + step.input * commands.front();
    commands.pop_front();
    if (10 * i >= 9 * count) {
      end = std::max(end, std::abs(s[0]));
    } else if (10 * i >= 4 * count && 10 * i < 5 * count) {
      middle = std::max(middle, std::abs(s[0]));
    }
  }
  return end / middle;
}

TEST(Stability, LoopsInTimeGrowBeyondTheLimitAndDecayBelowIt) {
  for (const AxisDynamics& axis : {AxisDynamics{0.1, 0.5}, AxisDynamics{0.15, 0.8, 100}}) {
    for (const int delay : {0, 7, 20, 33, 100}) {  // twentieths of a period
      const double limit = StabilityLimit(axis, 1e-3, delay * 1e-3 / 20);
      EXPECT_LT(Growth(axis, 0.98 * limit, 1e-3, delay), 1) << delay;
      EXPECT_GT(Growth(axis, 1.02 * limit, 1e-3, delay), 1) << delay;
    }
  }
}

TEST(Stability, LimitFallsWithDelayAndPeriodAndRisesWithDamping) {
  double last = StabilityLimit({0.1, 0.5}, 1e-3, 0);
  for (const double delay : {0.2e-3, 0.999e-3, 1e-3, 1.001e-3, 2.5e-3, 5e-3}) {
    const double limit = StabilityLimit({0.1, 0.5}, 1e-3, delay);
    EXPECT_LT(limit, last) << delay;
    last = limit;
  }
  EXPECT_LT(StabilityLimit({0.1, 0.5}, 2e-3, 0), StabilityLimit({0.1, 0.5}, 1e-3, 0));
  EXPECT_GT(StabilityLimit({0.1, 6.5, 300}, 1e-3, 0), StabilityLimit({0.1, 0.5}, 1e-3, 0));
  EXPECT_EQ(StabilityLimit({0.1, 0}, 1e-3, 0), 0);
}

TEST(Stability, PassiveWallsAreStable) {
  for (const double mass : {0.02, 0.1, 1.0}) {
    for (const double damping : {0.1, 0.5, 5.0}) {
      for (const double delay : {0.0, 1e-3, 4e-3}) {
        const double bound = PassivityBound(damping, 0, 0, 1e-3, delay);
        // 1e-6: where the two coincide, the limit is found to that.
        EXPECT_LE(bound, StabilityLimit({mass, damping}, 1e-3, delay) * (1 + 1e-6));
      }
    }
  }
}

TEST(Stability, PassivityBoundIsTheLesserOfDampingAndFriction) {
  EXPECT_DOUBLE_EQ(PassivityBound(0.5, 0.1, 2.5e-5, 1e-3), 1000);
  EXPECT_DOUBLE_EQ(PassivityBound(0.5, 0.01, 2.5e-5, 1e-3), 800);
  EXPECT_DOUBLE_EQ(PassivityBound(0.5, 0, 0, 1e-3), 1000);  // a continuous encoder
  EXPECT_DOUBLE_EQ(PassivityBound(0.5, 0.1, 2.5e-5, 1e-3, 1e-3), 1000.0 / 3);
}

TEST(Stability, AxesLimitsAtTheTipAreThoseOfTheAxisOverItsSquaredArm) {
  const DeviceAxes axes = AxesOf({});
  const double arm = 0.15, g = arm * arm;
  const auto limits = StiffnessLimits(axes, 1e-3, 0);
  const StiffnessLimit& pitch = limits[kPitch];
  const double at_tip =
      StabilityLimit({axes.inertia[kPitch] / g, axes.damping[kPitch] / g}, 1e-3, 0);
  EXPECT_NEAR(pitch.stability / g, at_tip, 3e-6 * at_tip);  // both to 1e-6
  EXPECT_NEAR(pitch.passivity / g,
              PassivityBound(axes.damping[kPitch] / g, axes.friction[kPitch] / arm,
                             axes.encoder_step[kPitch] * arm, 1e-3),
              1e-9);
  EXPECT_EQ(limits[kInsertion].Least(), 1000);
}

TEST(Stability, DamperThatIsZeroChangesNothingAndAnotherRaisesTheLimit) {
  const AxisDynamics device{0.1, 0.5};
  EXPECT_EQ(StabilityLimit(device, 1e-3, 0.4e-3), StabilityLimit(device, 1e-3, 0.4e-3, {0, 3}));
  // The controller's damper of half of m / lag, over three periods; 10 % below its limit the roots
  // are inside of the unit circle, 10 % above it outside.
  const SampledDamper damper{0.5 * 0.1 / 2e-3, 3};
  const double limit = StabilityLimit(device, 1e-3, 0, damper);
  EXPECT_GT(limit, 10 * StabilityLimit(device, 1e-3, 0));
  EXPECT_LT(SpectralRadius(device, 0.9 * limit, 1e-3, 0, damper), 1);
  EXPECT_GT(SpectralRadius(device, 1.1 * limit, 1e-3, 0, damper), 1);
}

}  // namespace
}  // namespace hpdm
