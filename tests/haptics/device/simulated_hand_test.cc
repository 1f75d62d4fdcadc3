#include "haptics/device/simulated_hand.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "engine/base/error.h"
#include "tests/support/hand_site.h"

namespace hpdm {
namespace {

constexpr HandScript kScripts[] = {HandScript::kPalpate,   HandScript::kTap,
                                   HandScript::kSlide,     HandScript::kGraspLift,
                                   HandScript::kGraspPull, HandScript::kRandom};

double Height(const HandIntent& intent) {
  return Site().normal_W.dot(intent.p_W - Site().p_target_W);
}

TEST(SimulatedHand, MinimumJerkStartsAndEndsAtRest) {
  EXPECT_EQ(MinimumJerk::Position(0), 0);
  EXPECT_EQ(MinimumJerk::Position(1), 1);
  EXPECT_EQ(MinimumJerk::Velocity(0), 0);
  EXPECT_EQ(MinimumJerk::Velocity(1), 0);
  EXPECT_EQ(MinimumJerk::Velocity(0.5), 1.875);
  for (double tau = 0.01; tau < 1; tau += 0.01) {
    const double h = 1e-5;
    const double slope =
        (MinimumJerk::Position(tau + h) - MinimumJerk::Position(tau - h)) / (2 * h);
    // Truncation h^2 / 6 * 60 = 1e-9 and round-off 1e-15 / h.
    EXPECT_NEAR(MinimumJerk::Velocity(tau), slope, 3e-9);
    EXPECT_LE(MinimumJerk::Velocity(tau), 1.875);
  }
}

TEST(SimulatedHand, ReachesPeakAtOnePointEightSevenFiveTimesTheMeanSpeed) {
  const HandOptions options = Options(HandScript::kPalpate);
  SimulatedHand hand(options, Site());
  double fastest = 0;
  for (Nanoseconds t = 0; t < 20 * kSecond; t += kTick) {
    fastest = std::max(fastest, hand.At(t).v_W.norm());
  }
  // A tick beside the peak of a 0.56 s reach is 2e-5 slower.
  EXPECT_NEAR(fastest, 1.875 * options.speed, 1e-4 * options.speed);
}

TEST(SimulatedHand, VelocityIsTheDerivativeOfPositionInEveryScript) {
  for (const HandScript script : kScripts) {
    SimulatedHand hand(Options(script, 1e-4), Site());
    HandIntent last = hand.At(0);
    const double h = 1e-4;
    for (Nanoseconds t = 100'000; t < 20 * kSecond; t += 100'000) {
      const HandIntent intent = hand.At(t);
      const Vector3d mean = (intent.v_W + last.v_W) / 2;
      // Trapezoid rule, h^2 / 12 times the third derivative (at most 60 d / T^3: 21 mm in 0.1 s;
      // 1.3e3 m/s^3), and half a step of the jump in jerk where way points meet.
      ASSERT_LT(((intent.p_W - last.p_W) / h - mean).norm(), 1e-5);
      last = intent;
    }
  }
}

TEST(SimulatedHand, PalpatePressesToDepthHoldsAndMovesOn) {
  const HandOptions options = Options(HandScript::kPalpate);
  SimulatedHand hand(options, Site());
  std::vector<Vector3d> pressed;
  Nanoseconds held = 0, longest = 0;
  for (Nanoseconds t = 0; t < 30 * kSecond; t += kTick) {
    const HandIntent intent = hand.At(t);
    ASSERT_GE(Height(intent), -options.depth - 1e-12);
    if (Height(intent) < -options.depth + 1e-12) {
      if (held == 0) pressed.push_back(intent.p_W);
      held += kTick;
      longest = std::max(longest, held);
    } else {
      held = 0;
    }
  }
  EXPECT_NEAR(ToSeconds(longest), 0.6, 0.01);  // within the flat ends of the movements around it
  ASSERT_GE(pressed.size(), 8u);
  for (std::size_t i = 0; i < pressed.size(); ++i) {
    Vector3d offset = pressed[i] - Site().p_target_W;
    offset -= offset.dot(Site().normal_W) * Site().normal_W;
    EXPECT_GE(offset.norm(), 0.010 - 1e-9);
    EXPECT_LE(offset.norm(), 0.020 + 1e-9);
    if (i > 0) {
      EXPECT_GT((pressed[i] - pressed[i - 1]).norm(), 1e-4);
    }
  }
}

TEST(SimulatedHand, TapsTwoToThreeTimesASecond) {
  const HandOptions options = Options(HandScript::kTap);
  SimulatedHand hand(options, Site());
  std::vector<double> taps;
  bool down = false;
  for (Nanoseconds t = 0; t < 20 * kSecond; t += kTick) {
    const bool now_down = Height(hand.At(t)) < -0.99 * options.depth;
    if (now_down && !down) taps.push_back(ToSeconds(t));
    down = now_down;
  }
  ASSERT_GT(taps.size(), 35u);
  for (std::size_t i = 1; i < taps.size(); ++i) {
    // Consecutive periods lie in [1/3, 1/2] s; the passage through 99 % shifts with them by ms.
    EXPECT_GT(taps[i] - taps[i - 1], 0.31);
    EXPECT_LT(taps[i] - taps[i - 1], 0.53);
  }
}

TEST(SimulatedHand, SlideMovesAlongTheSurfaceWhilePressed) {
  const HandOptions options = Options(HandScript::kSlide);
  SimulatedHand hand(options, Site());
  double farthest = 0;
  for (Nanoseconds t = 0; t < 20 * kSecond; t += kTick) {
    const HandIntent intent = hand.At(t);
    if (Height(intent) > -options.depth + 1e-9) continue;
    const Vector3d offset = intent.p_W - Site().p_target_W;
    farthest = std::max(farthest, (offset + options.depth * Site().normal_W).norm());
  }
  EXPECT_NEAR(farthest, 0.020, 1e-9);
}

TEST(SimulatedHand, GraspsCloseTheJawBeforeTheyPullAndOpenItAfter) {
  for (const HandScript script : {HandScript::kGraspLift, HandScript::kGraspPull}) {
    const HandOptions options = Options(script);
    SimulatedHand hand(options, Site());
    const Vector3d direction = script == HandScript::kGraspLift
                                   ? Site().normal_W
                                   : Vector3d((Site().p_trocar_W - Site().p_target_W).normalized());
    const Vector3d grasped = Site().p_target_W - 0.003 * Site().normal_W;
    double farthest = 0;
    int closings = 0;
    double last_jaw = 1;
    for (Nanoseconds t = 0; t < 20 * kSecond; t += kTick) {
      const HandIntent intent = hand.At(t);
      if (intent.jaw == 0) {
        farthest = std::max(farthest, direction.dot(intent.p_W - grasped));
      } else if (intent.jaw < 1) {  // the jaw moves only at the place of the grasp
        EXPECT_LT((intent.p_W - grasped).norm(), 1e-12);
      }
      if (intent.jaw == 0 && last_jaw > 0) ++closings;
      last_jaw = intent.jaw;
    }
    EXPECT_NEAR(farthest, options.depth, 1e-12);
    EXPECT_GE(closings, 4);
  }
}

TEST(SimulatedHand, EveryScriptStaysNearItsTargetForTenMinutes) {
  for (const HandScript script : kScripts) {
    HandOptions options = Options(script, 1e-4);
    SimulatedHand hand(options, Site());
    for (Nanoseconds t = 0; t < 600 * kSecond; t += 20 * kTick) {
      const HandIntent intent = hand.At(t);
      ASSERT_TRUE(intent.p_W.allFinite() && intent.v_W.allFinite());
      // After the approach: the documented 45 mm + depth, and the tremor.
      if (t > 2 * kSecond) {
        ASSERT_LT((intent.p_W - Site().p_target_W).norm(), 0.045 + options.depth + 1e-3);
      }
      ASSERT_GE(intent.jaw, 0);
      ASSERT_LE(intent.jaw, 1);
    }
  }
}

TEST(SimulatedHand, TremorLiesBetweenEightAndTwelveHertz) {
  const double amplitude = 1e-4;
  SimulatedHand with(Options(HandScript::kPalpate, amplitude), Site());
  SimulatedHand without(Options(HandScript::kPalpate), Site());
  // Ten seconds at 200 Hz, windowed (Hann), so that bins are 0.1 Hz and leakage is local.
  const int n = 2000;
  std::vector<double> tremor(n);
  double square = 0;
  for (int i = 0; i < n; ++i) {
    const Nanoseconds t = i * 5 * kTick;
    tremor[i] = (with.At(t).p_W - without.At(t).p_W).x();
    square += tremor[i] * tremor[i];
    tremor[i] *= 0.5 - 0.5 * std::cos(2 * std::numbers::pi * i / n);
  }
  double inside = 0, all = 0;
  for (int bin = 0; bin <= 1000; ++bin) {
    double re = 0, im = 0;
    for (int i = 0; i < n; ++i) {
      const double angle = 2 * std::numbers::pi * bin * i / n;
      re += tremor[i] * std::cos(angle);
      im += tremor[i] * std::sin(angle);
    }
    const double power = re * re + im * im;
    all += power;
    if (bin >= 78 && bin <= 122) inside += power;  // two bins of leakage on either side
  }
  EXPECT_GT(inside / all, 0.999);
  // The root mean square of one sinusoid of that amplitude; beats within 10 s cost a few per cent.
  EXPECT_NEAR(std::sqrt(square / n), amplitude / std::sqrt(2.0), 0.1 * amplitude);
}

TEST(SimulatedHand, SeedsReproduceAndDiffer) {
  for (const HandScript script : kScripts) {
    HandOptions options = Options(script, 1e-4);
    SimulatedHand a(options, Site()), b(options, Site());
    options.seed = 2;
    SimulatedHand c(options, Site());
    bool differs = false;
    for (Nanoseconds t = 0; t < 10 * kSecond; t += kTick) {
      const HandIntent from_a = a.At(t), from_b = b.At(t);
      ASSERT_EQ(from_a.p_W, from_b.p_W);
      ASSERT_EQ(from_a.jaw, from_b.jaw);
      differs = differs || from_a.p_W != c.At(t).p_W;
    }
    EXPECT_TRUE(differs);
  }
}

TEST(SimulatedHand, RefusesOptionsThatCannotMove) {
  HandOptions options;
  options.speed = 0;
  EXPECT_THROW(SimulatedHand(options, Site()), InputError);
  options = {};
  options.stiffness = -1;
  EXPECT_THROW(SimulatedHand(options, Site()), InputError);
  HandSite site = Site();
  site.normal_W.setZero();
  EXPECT_THROW(SimulatedHand(HandOptions{}, site), InputError);
}

}  // namespace
}  // namespace hpdm
