// Presses on springs in one dimension. The hand's work is summed here, apart from the tank.
#include "haptics/safety/energy_tank.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "tests/support/haptic_bench.h"

namespace hpdm {
namespace {

constexpr double kPressed = 0.01;  // m
constexpr double kSpring = 100;    // N/m
constexpr int kWay = 100;          // ticks from touch to deepest, and back
const double kStored = 0.5 * kSpring * kPressed * kPressed;

// Presses one or two springs with tools whose force a tank limits, and sums the work of the hands.
struct Springs {
  explicit Springs(const EnergyTankOptions& options = {}, std::size_t tools = 1)
      : tank(options), last_forces_W(tools, Vector3d::Zero()), last_depths(tools) {
    Tick(last_depths, last_depths);
  }

  // One tick with the given depths (m) and stiffnesses (N/m). Returns the share.
  double Tick(std::vector<double> depths, std::vector<double> stiffnesses,
              ContactKind kind = ContactKind::kPress) {
    const std::size_t count = depths.size();
    std::vector<EnergyTank::Press> presses(count);
    std::vector<Vector3d> forces_W(count);
    for (std::size_t i = 0; i < count; ++i) {
      const double pressed = std::max(depths[i], 0.0);
      presses[i].p_tip_W = Vector3d(0, 0, -depths[i]);
      presses[i].reaction_W = Vector3d(0, 0, stiffnesses[i] * pressed);
      presses[i].tissue_stored = 0.5 * stiffnesses[i] * pressed * pressed;
      presses[i].kind = pressed > 0 ? kind : ContactKind::kNone;
    }
    share = tank.Limit(presses);
    for (std::size_t i = 0; i < count; ++i) {
      forces_W[i] = share * presses[i].reaction_W;
      work += 0.5 * (forces_W[i] + last_forces_W[i]).z() * (depths[i] - last_depths[i]);
    }
    tank.Observe(forces_W);
    last_forces_W = forces_W;
    last_depths = depths;
    return share;
  }
  // Moves one tool from a depth to another. Returns the least share, or one that is not a number.
  double Move(double from, double to, double stiffness, ContactKind kind = ContactKind::kPress) {
    double least = 1;
    for (int i = 1; i <= kWay; ++i) {
      const double now = Tick({from + (to - from) * i / kWay}, {stiffness}, kind);
      if (!(now >= least)) least = now;
    }
    return least;
  }

  EnergyTank tank;
  double work = 0;  // of the hands, J
  double share = 1;
  std::vector<Vector3d> last_forces_W;
  std::vector<double> last_depths;
};

TEST(EnergyTank, LeavesALinearSpringAlone) {
  Springs springs;
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(springs.Move(0, kPressed, kSpring), 1, 1e-9);
    EXPECT_NEAR(springs.Move(kPressed, 0, kSpring), 1, 1e-9);
  }
  EXPECT_NEAR(springs.work, 0, 1e-12);
}

// Also of tissue that dissipates: it gives less back than the tank has.
TEST(EnergyTank, LeavesTissueThatSoftensAlone) {
  Springs springs;
  springs.Move(0, kPressed, kSpring);
  EXPECT_EQ(springs.Move(kPressed, 0, 0.6 * kSpring), 1);
}

TEST(EnergyTank, GivesBackNoMoreThanWasPutIn) {
  for (const double stiffer : {1.05, 1.5, 3.0}) {
    Springs free({.control = false});
    free.Move(0, kPressed, kSpring);
    free.Move(kPressed, 0, stiffer * kSpring);
    EXPECT_NEAR(free.work, (1 - stiffer) * kStored, 0.02 * kStored) << "without the tank";

    Springs springs;
    springs.Move(0, kPressed, kSpring);
    springs.Move(kPressed, 0, stiffer * kSpring);
    EXPECT_GT(springs.work, -0.01 * kStored - 2e-6) << stiffer;
    EXPECT_LT(springs.work, 0.06 * kStored) << "nor does it take much: " << stiffer;
  }
}

// Without any energy in the tank the tissue gives back half of what it gives before the limit is full.
TEST(EnergyTank, GivesLittleOfAPressThatBeginsDeep) {
  Springs springs;
  springs.Tick({kPressed}, {0});
  springs.Move(kPressed, 0, kSpring);
  EXPECT_GT(springs.work, -kStored / 12);
}

TEST(EnergyTank, LeavesTheFullForceToAToolThatStandsStill) {
  Springs springs;
  springs.Move(0, kPressed, kSpring);
  EXPECT_EQ(springs.Move(kPressed, kPressed, 2 * kSpring), 1);
  springs.Move(kPressed, 0.8 * kPressed, 2 * kSpring);
  EXPECT_LT(springs.share, 0.9);
  for (int i = 0; i < 100; ++i) springs.Move(0.8 * kPressed, 0.8 * kPressed, 2 * kSpring);
  EXPECT_NEAR(springs.share, 1, 1e-3);
  EXPECT_EQ(springs.Move(0.8 * kPressed, kPressed, 2 * kSpring), 1) << "pressed further";
}

// A hand feels its force change by about a tenth.
TEST(EnergyTank, ChangesTheForceWithoutAStep) {
  Springs springs;
  springs.Move(0, kPressed, kSpring);
  springs.Tick({kPressed}, {2 * kSpring});
  double last = springs.last_forces_W[0].z(), largest = 0;
  for (int i = 1; i <= 2000; ++i) {
    springs.Tick({kPressed * (1 - i / 2000.0)}, {2 * kSpring});
    const double force = springs.last_forces_W[0].z();
    largest = std::max(largest, std::abs(force - last));
    last = force;
  }
  EXPECT_LT(largest, 0.01 * 2 * kSpring * kPressed);
}

// A force that fades out after its contact: it stores nothing, and the tip moves on.
struct Fade {
  // One tick with the tip `way` m beyond the end of the contact. Returns the share.
  double Tick(double way, double force) {
    const EnergyTank::Press press{.p_tip_W = {0, 0, way}, .reaction_W = {0, 0, force}};
    const double share = springs.tank.Limit(std::array{press});
    springs.tank.Observe(std::array{Vector3d(share * press.reaction_W)});
    work -= 0.5 * (share * force + springs.last_forces_W[0].z()) * (way - last);
    springs.last_forces_W[0].z() = share * force;
    last = way;
    return share;
  }

  Springs& springs;
  double last = 0, work = 0;  // m, J of the hand
};

TEST(EnergyTank, KeepsItsShareOfAForceThatFadesOutWhereTheTipRests) {
  Springs springs;
  springs.Move(0, kPressed, kSpring);
  springs.Move(kPressed, 0.3 * kPressed, 2 * kSpring);
  const double last = springs.share;
  EXPECT_LT(last, 0.9);
  Fade fade{springs, -0.3 * kPressed};
  for (int i = 0; i < 90; ++i) EXPECT_NEAR(fade.Tick(-0.3 * kPressed, 0.1), last, 1e-12);
  for (int i = 90; i < 120; ++i) fade.Tick(-0.3 * kPressed, 0.1);
  EXPECT_EQ(fade.Tick(-0.3 * kPressed, 0.1), 1) << "all tools have been free for long";
}

TEST(EnergyTank, GivesNoMoreThanIsLeftWhileAForceFadesOut) {
  for (const double left : {0.2, 0.02, 0.0}) {
    Springs springs;
    springs.Move(0, kPressed, kSpring);
    springs.Move(kPressed, 0, (1 - left) * kSpring);
    EXPECT_EQ(springs.share, 1) << left;
    Fade fade{springs};
    double last = 1;
    for (int i = 1; i < 90; ++i) {
      const double share = fade.Tick(1e-4 * i, 0.5);
      EXPECT_LE(share, last + 1e-12) << "only falls: " << left;
      last = share;
    }
    EXPECT_LE(fade.work, -0.7 * left * kStored) << left;
    EXPECT_GT(springs.work + fade.work, -0.01 * kStored - 2e-6) << left;
  }
}

// The springs store the same all the way: only what the hand has done tells that it gets too much.
TEST(EnergyTank, GivesNoMoreThanWasPutInWhereTissueFollowsTheTip) {
  for (const double speed : {0.01, 0.1, 0.5}) {  // m/s
    Springs springs;
    springs.Move(0, kPressed, kSpring);
    double work = springs.work, last = springs.last_forces_W[0].z();
    const double way = 1e-3 * speed;  // m, in a tick
    for (double out = way; out < 2 * kPressed; out += way) {
      const EnergyTank::Press press{.p_tip_W = {0, 0, -kPressed + out},
                                    .reaction_W = {0, 0, kSpring * kPressed},
                                    .tissue_stored = kStored,
                                    .kind = ContactKind::kPress};
      const double force = springs.tank.Limit(std::array{press}) * press.reaction_W.z();
      springs.tank.Observe(std::array{Vector3d(0, 0, force)});
      work -= 0.5 * (force + last) * way;
      last = force;
    }
    EXPECT_GT(work, -0.01 * kStored) << speed << " m/s; untouched it would be -3 kStored";
  }
}

TEST(EnergyTank, LetsOneHandHaveWhatAnotherPutIn) {
  Springs springs({}, 2);
  for (int i = 1; i <= kWay; ++i) springs.Tick({kPressed * i / kWay, 0}, {kSpring, 0});
  // The first tool's tissue comes up to the second one, which stands below its surface.
  springs.Tick({kPressed, kPressed}, {0, 0});
  double least = 1;
  for (int i = kWay; i >= 0; --i) {
    least = std::min(least, springs.Tick({kPressed, kPressed * i / kWay}, {0, kSpring}));
  }
  EXPECT_NEAR(least, 1, 0.02);
}

TEST(EnergyTank, BeginsAnewOnceTheToolsAreFree) {
  Springs springs;
  springs.Move(0, kPressed, kSpring);
  springs.Move(kPressed, 0, 0.5 * kSpring);  // leaves half of the energy in the tank
  springs.Move(0, -kPressed, kSpring);
  springs.Move(-kPressed, 0, kSpring);
  EXPECT_EQ(springs.tank.energy(), 0);
  springs.Move(0, kPressed, kSpring);
  EXPECT_LT(springs.Move(kPressed, 0, 1.5 * kSpring), 0.9) << "the last contact's is not available";
}

// As if the tool had been pressed to where it then is.
TEST(EnergyTank, DoesNotCountAReadingThatJumps) {
  Springs springs;
  springs.Move(0, kPressed, kSpring);
  springs.Tick({0.2}, {kSpring});
  springs.Tick({kPressed}, {kSpring});
  EXPECT_EQ(springs.share, 1);
  EXPECT_NEAR(springs.tank.energy(), kStored, 1e-12);
  EXPECT_NEAR(springs.Move(kPressed, 0, kSpring), 1, 1e-9);
}

// The guard replaces the force of such a tick.
TEST(EnergyTank, SurvivesAForceThatIsNotANumber) {
  Springs springs;
  springs.Move(0, kPressed, kSpring);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  springs.tank.Limit(std::array{EnergyTank::Press{.p_tip_W = {0, 0, -kPressed},
                                                  .reaction_W = Vector3d::Constant(nan),
                                                  .tissue_stored = nan,
                                                  .wall_stored = nan,
                                                  .kind = ContactKind::kPress}});
  springs.tank.Observe(springs.last_forces_W);
  EXPECT_NEAR(springs.Move(kPressed, 0, kSpring), 1, 1e-9);
}

TEST(EnergyTank, DoesNotLimitJaws) {
  Springs springs;
  springs.Move(0, kPressed, kSpring);
  springs.Tick({kPressed}, {kSpring}, ContactKind::kGrasp);
  EXPECT_EQ(springs.Move(kPressed, 0, 2 * kSpring), 1) << "the jaws did work";
  springs.Move(0, -kPressed, kSpring);
  springs.Move(-kPressed, kPressed, kSpring);
  EXPECT_LT(springs.Move(kPressed, 0, 2 * kSpring), 0.9);
}

// The loop's patches come from a step at a time. The tissue has become stiffer from one to the next.
TEST(EnergyTank, HoldsForTheLoopsForce) {
  for (const bool control : {true, false}) {
    Bench bench(control);
    bench.Settle();
    double work = 0, put_in = 0;
    bool limited = false;
    Vector3d last_force_W = Vector3d::Zero(), last_W(0, 0, kTipRadius + 0.002);
    const auto move = [&](double to) {
      const double from = last_W.z();
      for (int i = 1; i <= 99; ++i) {
        if (i % 33 == 1) bench.PublishPatch();
        const Vector3d tip_W(0, 0, from + (to - from) * i / 99);
        bench.device.MoveTip(tip_W);
        const ToolSample tool = bench.Tick().tools[0];
        const double done = -0.5 * (tool.force_W + last_force_W).dot(tip_W - last_W);
        work += done;
        put_in += std::max(done, 0.0);
        limited = limited || (tool.guard_flags & kGuardTank) != 0;
        last_W = tip_W;
        last_force_W = tool.force_W;
      }
    };
    move(kTipRadius - 0.004);
    bench.stiffness *= 1.6;
    move(kTipRadius - 0.004);
    move(kTipRadius + 0.002);
    EXPECT_EQ(limited, control);
    if (control) {
      EXPECT_GT(work, -0.02 * put_in);
    } else {
      EXPECT_LT(work, -0.3 * put_in) << "what the tank takes";
    }
  }
}

}  // namespace
}  // namespace hpdm
