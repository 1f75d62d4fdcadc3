#include "haptics/safety/passivity.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "haptics/device/simulated_hand.h"
#include "haptics/safety/stability.h"
#include "tests/support/counted_allocations.h"

namespace hpdm {
namespace {

constexpr Nanoseconds kPeriod = 1'000'000;
constexpr double kT = 1e-3;
constexpr double kArm = 0.15;  // m, insertion

// The device at pitch = yaw = 0 with the shaft along -z: the tip's motion by its axes.
Matrix3d Jacobian() {
  Matrix3d J;
  J << 0, kArm, 0, kArm, 0, 0, 0, 0, -1;
  return J;
}

// Drives a controller with tip positions and displays the given forces.
class Bench {
 public:
  explicit Bench(const PassivityOptions& options) : control(options) {}

  // The tip (m) at the time of the sample; the tissue's force on the hand (N). Returns the damping.
  Vector3d Tick(const Vector3d& p_W, const Vector3d& reaction_W, bool force_on = true,
                Nanoseconds age = 0, const WallPress& wall = {}) {
    const Nanoseconds now = tick++ * kPeriod;
    DeviceSample sample{.time_ns = now - age, .valid = true};
    sample.joints.head<3>() = Jacobian().inverse() * p_W;
    const Vector3d damping_W = control.Damp(now, sample, p_W, Jacobian(), reaction_W, wall);
    displayed_W = force_on ? Vector3d(reaction_W + damping_W) : Vector3d::Zero();
    control.Observe(displayed_W, 1, force_on);
    return damping_W;
  }

  PassivityControl control;
  Vector3d displayed_W = Vector3d::Zero();
  Nanoseconds tick = 0;
};

PassivityOptions Off() {
  PassivityOptions options;
  options.control = false;
  return options;
}

// Returns a device without dissipation, with the mass m on every axis at the tip.
PassivityOptions Bare(double mass) {
  PassivityOptions options;
  options.device = {};
  options.device.inertia << mass * kArm * kArm, mass * kArm * kArm, mass;
  return options;
}

TEST(Passivity, EnergyOfAHeldSpringIsExact) {
  // A sampled spring pulled around a closed course gives K/2 sum |dp|^2 to the hand, by summation
  // by parts of -F_k . (p_(k+1) - p_k) with F_k = -K p_k.
  const double K = 700;
  HandRandom random(3);
  std::vector<Vector3d> course(200, Vector3d::Zero());
  for (std::size_t k = 1; k + 1 < course.size(); ++k) {
    course[k] = course[k - 1] + 1e-4 * Vector3d(random.Uniform(-1, 1), random.Uniform(-1, 1),
                                                random.Uniform(-1, 1));
  }
  Bench bench(Off());
  double work = 0, generated = 0;
  for (std::size_t k = 0; k < course.size(); ++k) {
    if (k > 0) {
      work += K * course[k - 1].dot(course[k] - course[k - 1]);
      generated += 0.5 * K * (course[k] - course[k - 1]).squaredNorm();
    }
    bench.Tick(course[k], -K * course[k]);
    // Round-off of 200 terms of up to 1e-6 J.
    ASSERT_NEAR(bench.control.energy(), work, 1e-18);
  }
  EXPECT_NEAR(bench.control.energy(), -generated, 1e-18);
  EXPECT_LT(bench.control.energy(), -1e-5);
}

TEST(Passivity, EnergyCountsTheForceThatWasDisplayedWhenAnOldSampleWasTaken) {
  // Samples are 3.4 ms old: 0.4 of the motion between two of them was under the force of five ticks
  // ago and 0.6 under that of four ticks ago.
  constexpr Nanoseconds kAge = 3'400'000;
  const auto p = [](double t) { return Vector3d(0.002 * std::sin(40 * t), 0, 0.001 * t); };
  const auto f = [](int k) { return Vector3d(std::cos(0.3 * k), 0.2, 0.1 * k); };
  Bench bench(Off());
  double work = 0;
  for (int k = 0; k < 120; ++k) {
    const double t = k * kT - ToSeconds(kAge);
    bench.Tick(p(t), f(k), true, kAge);
    if (k >= 5) {
      work -= (0.6 * f(k - 4) + 0.4 * f(k - 5)).dot(p(t) - p(t - kT));
    }
    if (k == 4) work = bench.control.energy();  // the first forces have no history
    ASSERT_NEAR(bench.control.energy(), work, 1e-15);
  }
}

TEST(Passivity, FreeMotionGetsNoDamping) {
  Bench bench(Bare(0.1));
  HandRandom random(1);
  for (int k = 0; k < 2000; ++k) {
    const Vector3d p(0.02 * std::sin(0.02 * k), 1e-4 * random.Uniform(-1, 1), 0.01);
    EXPECT_EQ(bench.Tick(p, Vector3d::Zero()), Vector3d::Zero());
    EXPECT_EQ(bench.control.damping(), 0);
  }
  EXPECT_EQ(bench.control.energy(), 0);
}

// The tip in a wall of stiffness K at z < 0, moved by the forces and a push of 1 N into it, on the
// device's insertion axis. Returns the greatest excursion (m) about the equilibrium in the last
// second of five, after a start at 20 mm/s.
double Excursion(PassivityOptions options, const AxisDynamics& axis, double K,
                 double* greatest_force = nullptr) {
  options.device.inertia[kInsertion] = axis.mass;
  options.device.damping[kInsertion] = axis.damping;
  const HeldForceStep step = ExactStep(axis, kT);
  Bench bench(options);
  Eigen::Vector2d s(-1 / K, 0.02);  // z, z'
  double greatest = 0;
  for (int k = 0; k < 5000; ++k) {
    bench.Tick({0, 0, s[0]}, {0, 0, std::max(0.0, -K * s[0])});
    s = step.transition * s + step.input * (bench.displayed_W.z() - 1);
    if (k >= 4000) greatest = std::max(greatest, std::abs(s[0] + 1 / K));
    if (greatest_force != nullptr) {
      *greatest_force = std::max(*greatest_force, bench.displayed_W.norm());
    }
  }
  return greatest;
}

TEST(Passivity, WallBeyondTheLimitShakesWithoutTheControllerAndRestsWithIt) {
  const AxisDynamics axis{0.1, 0.5};
  PassivityOptions on;
  on.device.friction.setZero();
  on.device.encoder_step.setZero();
  PassivityOptions off = on;
  off.control = false;
  for (const double beyond : {1.5, 3.0, 10.0}) {
    const double K = beyond * StabilityLimit(axis, kT, 0);
    double force = 0;
    const double shaken = Excursion(off, axis, K), held = Excursion(on, axis, K, &force);
    // It leaves the wall, which it was pressed into by 1 N.
    EXPECT_GT(shaken, 1 / K) << beyond;
    // The rest is the motion that the energy of `reserve` and the leak allow: about 1e-5 J, 14 mm/s
    // of 0.1 kg at 100 rad/s and above.
    EXPECT_LT(held, 1e-4) << beyond;
    EXPECT_LT(K * held, 0.25) << beyond;
    // The start alone takes sqrt(K m) 20 mm/s + 1 N; damping adds at most c v = 25 x 0.02 N.
    EXPECT_LT(force, std::sqrt(K * 0.1) * 0.02 + 1 + 0.5) << beyond;
  }
}

TEST(Passivity, StableWallsAreLeftAsTheyAre) {
  const AxisDynamics axis{0.1, 0.5};
  PassivityOptions on, off = Off();
  EXPECT_EQ(Excursion(on, axis, 400), Excursion(off, axis, 400));
}

TEST(Passivity, SwitchedOffItAddsNothing) {
  Bench bench(Off());
  for (int k = 0; k < 500; ++k) {
    const double z = -1e-3 + 5e-4 * ((k & 2) - 1);
    EXPECT_EQ(bench.Tick({0, 0, z}, {0, 0, -5000 * z}), Vector3d::Zero());
    EXPECT_EQ(bench.control.damping(), 0);
  }
  EXPECT_LT(bench.control.energy(), -0.01);  // and would have had cause to
}

// A hand with tremor presses and releases by 15 mm at 1 Hz, in tissue of 300 N/m, read through
// the encoders of the default device: no tick may feel the controller.
TEST(Passivity, OrdinaryContactIsNeverDampedThroughCoarseEncoders) {
  const PassivityOptions options;
  Bench bench(options);
  for (int k = 0; k < 5000; ++k) {
    const double t = k * kT;
    Vector3d q(0.05 * std::sin(3 * t) + 3e-4 * std::sin(60 * t), 0.04 * std::cos(2 * t),
               0.008 + 0.0075 * std::sin(2 * M_PI * t) + 1e-4 * std::sin(65 * t));
    for (int i = 0; i < 3; ++i) {
      const double step = options.device.encoder_step[i];
      q[i] = std::round(q[i] / step) * step;
    }
    const Vector3d p_W = Jacobian() * q;
    const Vector3d normal = Vector3d(0.4, -0.3, 1).normalized();
    bench.Tick(p_W, 300 * std::max(0.0, -normal.dot(p_W)) * normal);
    ASSERT_EQ(bench.control.damping(), 0) << k;
  }
}

TEST(Passivity, AStillTipUnderAForceThatMovesIsNotDamped) {
  Bench bench(Bare(0.1));
  for (int k = 0; k < 3000; ++k) {  // breathing: 0.5 Hz, 1 N, in steps of the deformation loop
    const double force = 1 - std::cos(2 * M_PI * 0.5 * kT * (k - k % 33));
    bench.Tick({0, 0, -0.003}, {0, 0, force});
    ASSERT_EQ(bench.control.damping(), 0) << k;
  }
  EXPECT_EQ(bench.control.energy(), 0);
}

TEST(Passivity, OneEncoderCountMovesTheDampingForceByNoMoreThanTheRipple) {
  PassivityOptions options = Bare(10);  // a heavy device, so that the ripple is what limits
  options.device.encoder_step = AxesOf({}).encoder_step;
  const double count = options.device.encoder_step[kInsertion];
  Bench bench(options);
  // Overdraw the account: a spring of 20 kN/m, shaken.
  for (int k = 0; k < 100; ++k) {
    const double z = -0.01 + ((k & 2) - 1) * 2e-4;
    bench.Tick({0, 0, z}, {0, 0, -20000 * z});
  }
  Vector3d last = bench.Tick({0, 0, -0.01}, {0, 0, 200});
  for (int k = 0; k < 6; ++k) bench.Tick({0, 0, -0.01}, {0, 0, 200});
  last = bench.Tick({0, 0, -0.01}, {0, 0, 200});
  ASSERT_GT(bench.control.damping(), 0);
  EXPECT_EQ(last, Vector3d::Zero());
  const Vector3d moved = bench.Tick({0, 0, -0.01 + count}, {0, 0, 200});
  EXPECT_GT(moved.norm(), 0);
  EXPECT_LE(moved.norm(), options.ripple * (1 + 1e-9));  // joints from p: round-off
}

// A reaction that jumps under a fast tip gives it half the jump times the motion in a tick.
TEST(Passivity, AFastMotionIsNotBrakedForMoreThanItOwes) {
  Bench bench(Bare(0.15));
  const double speed = 0.5, jump = 0.1;
  double paid = 0;
  for (int k = 0; k < 100; ++k) {
    const Vector3d reaction(0, 0, k < 50 ? 0.3 : 0.3 + jump);
    const Vector3d added = bench.Tick({0, 0, -speed * k * kT}, reaction);
    paid += added.norm() * speed * kT;
    const double owed = 0.5 * jump * speed * kT;
    // Paid in 5 ms: 10 mN, against 18 N of the full damping at that speed.
    EXPECT_LE(added.norm(), owed / (speed * PassivityOptions().pay) * (1 + 1e-9));
    if (k > 52 && k < 56) {
      EXPECT_GT(added.norm(), 0);
    }
    EXPECT_LE(paid, owed);
  }
}

// A tip that starts inside a wall is pushed out by no more than the reserve, but soft tissue at the
// same tip pushes it out with all of its force.
TEST(Passivity, LimitsTheWallsPartOfTheReactionOnly) {
  constexpr double kWall = 2000, kSoft = 100, kDepth = 0.005;  // N/m, N/m, m
  Bench bench(Bare(0.1));
  double work_of_wall = 0;  // on the hand
  Vector3d last_W = Vector3d::Zero();
  for (int k = 0; k < 100; ++k) {
    const double depth = kDepth * (1 - 0.01 * k);
    const WallPress wall{.stored = 0.5 * kWall * depth * depth,
                         .reaction_W = Vector3d(0, 0, kWall * depth),
                         .p_tip_organ_W = Vector3d(0, 0, -depth)};
    const Vector3d soft_W(kSoft * depth, 0, kSoft * depth);
    bench.Tick(wall.p_tip_organ_W, wall.reaction_W + soft_W, true, 0, wall);
    EXPECT_NEAR(bench.displayed_W.x(), soft_W.x(), 1e-12);
    // The controller's damping may take a part: 0.1 N s/m at 0.05 m/s.
    EXPECT_GE(bench.displayed_W.z(), soft_W.z() - 0.005);
    work_of_wall += last_W.z() * 0.01 * kDepth;
    last_W = bench.displayed_W - soft_W;
  }
  EXPECT_LE(work_of_wall, 2 * PassivityOptions().reserve);
}

TEST(Passivity, ForcesOffSettlesTheAccount) {
  Bench bench(Bare(0.1));
  const auto shake = [&](int k) {
    const double z = -0.01 + ((k & 2) - 1) * 2e-4;
    bench.Tick({0, 0, z}, {0, 0, -20000 * z});
  };
  for (int k = 0; k < 100; ++k) shake(k);
  ASSERT_GT(bench.control.damping(), 0);
  ASSERT_LT(bench.control.energy(), 0);
  bench.Tick({0, 0, -0.01}, {0, 0, 200}, false);
  EXPECT_EQ(bench.control.energy(), 0);
  EXPECT_EQ(bench.control.damping(), 0);
  bench.Tick({0, 0, -0.01}, {0, 0, 200});
  EXPECT_EQ(bench.control.damping(), 0);
}

TEST(Passivity, InvalidSamplesAndForcesThatAreNotFiniteLeaveItFinite) {
  Bench bench(Bare(0.1));
  const Vector3d nan = Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  for (int k = 0; k < 300; ++k) {
    DeviceSample sample{.time_ns = bench.tick * kPeriod, .valid = k % 7 != 0};
    const double z = -0.01 + ((k & 2) - 1) * 2e-4;
    sample.joints[kInsertion] = -z;
    const Vector3d reaction = k % 11 == 0 ? nan : Vector3d(0, 0, -20000 * z);
    const Vector3d added =
        bench.control.Damp(bench.tick * kPeriod, sample, {0, 0, z}, Jacobian(), reaction);
    ASSERT_TRUE(added.allFinite());
    bench.control.Observe(reaction.allFinite() ? Vector3d(reaction + added) : bench.displayed_W, 1,
                          true);
    if (reaction.allFinite()) bench.displayed_W = reaction + added;
    ++bench.tick;
    ASSERT_TRUE(std::isfinite(bench.control.energy()) && std::isfinite(bench.control.damping()));
  }
}

TEST(Passivity, AllocatesNothing) {
  if (!kCountsAllocations) GTEST_SKIP() << "the sanitizer's allocator is not counted";
  Bench bench(Bare(0.1));
  const long before = AllocationsOfThisThread();
  for (int k = 0; k < 300; ++k) {
    const double z = -0.01 + ((k & 2) - 1) * 2e-4;
    bench.Tick({0, 0, z}, {0, 0, -20000 * z});
  }
  EXPECT_EQ(AllocationsOfThisThread(), before);
  EXPECT_GT(bench.control.damping(), 0);
}

}  // namespace
}  // namespace hpdm
