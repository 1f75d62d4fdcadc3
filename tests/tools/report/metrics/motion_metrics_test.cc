// Time series of instruments whose figures are known in closed form.

#include "tools/report/metrics/motion_metrics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

#include "haptics/device/impulse_engine.h"

namespace hpdm {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kTick = 0.001;

/// Segments of a time series known at every time, sampled at 1 kHz; `keep` selects the ticks.
std::vector<TimeSeriesSegment> Segments(
    double seconds, const std::function<MotionVector(double)>& series,
    const std::function<bool(int)>& keep = [](int) { return true; }) {
  UniformTimeSeries uniform;
  for (int tick = 0; tick <= std::lround(seconds / kTick); ++tick) {
    if (keep(tick)) uniform.Add(tick * kTick, series(tick * kTick));
  }
  uniform.Break();
  return uniform.segments();
}

MotionVector AtTip(const Vector3d& p) {
  MotionVector series = MotionVector::Zero();
  series.segment<3>(kMotionTip) = p;
  return series;
}

/// Completed share, 0..1, of a minimum-jerk movement (Flash and Hogan 1985) at share s of its time.
double MinimumJerk(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return s * s * s * (10 + s * (-15 + 6 * s));
}

/// `count` such movements of `way` (m) there and back, each `length` s and followed by as long a
/// rest.
MotionVector ThereAndBack(double time, int count, double way, double length) {
  double x = 0;
  for (int k = 0; k < count; ++k) {
    const double done = MinimumJerk((time - length * (0.5 + 2 * k)) / length);
    x += (k % 2 == 0 ? 1 : -1) * way * done;
  }
  return AtTip({x, 0, 0});
}

TEST(UniformTimeSeries, MeansOfALineAreItsMiddles) {
  const auto segments = Segments(1, [](double t) { return AtTip({3 * t, 0, 1}); });
  ASSERT_EQ(segments.size(), 1u);
  EXPECT_EQ(segments[0].samples.size(), 200u);
  for (std::size_t i = 0; i < 200; ++i) {
    const double middle = (static_cast<double>(i) + 0.5) * kMotionPeriod;
    EXPECT_NEAR(segments[0].samples[i][0], 3 * middle, 1e-12);  // rounding
  }
}

TEST(UniformTimeSeries, EndsASegmentWhereTheTicksDo) {
  const auto segments = Segments(
      3,
      [](double t) {
        return AtTip({t, 0, 0});
      },
      [](int tick) { return tick < 1000 || tick >= 1200; });
  ASSERT_EQ(segments.size(), 2u);
  EXPECT_NEAR(segments[1].start, 1.2 + kMotionPeriod / 2, 1e-12);
}

TEST(SmoothZeroPhase, LeavesALineAndHalvesThePowerAtTheCutoff) {
  std::vector<MotionVector> line, wave;
  for (int i = 0; i < 2000; ++i) {
    const double t = i * kMotionPeriod;
    line.push_back(MotionVector::Constant(1 - 2 * t));
    wave.push_back(MotionVector::Constant(std::sin(2 * kPi * kMotionCutoff * t)));
  }
  SmoothZeroPhase(kMotionCutoff, kMotionPeriod, &line);
  SmoothZeroPhase(kMotionCutoff, kMotionPeriod, &wave);
  double square = 0;
  for (int i = 0; i < 2000; ++i) {
    EXPECT_NEAR(line[i][0], 1 - 2 * i * kMotionPeriod, 1e-6);  // the start's transient, died out
    if (i >= 500 && i < 1500) square += wave[i][0] * wave[i][0];
  }
  // Half of a sine's mean square, over whole periods; the bilinear transform bends frequencies by
  // less than 1 % here.
  EXPECT_NEAR(square / 1000, 0.25, 0.01);
}

TEST(MotionMetrics, ACirclesPathIsItsLength) {
  constexpr double kRadius = 0.03, kTurns = 5, kSeconds = 10;
  const MotionMetrics metrics = MeasureMotion(Segments(kSeconds, [](double t) {
    const double angle = 2 * kPi * kTurns * t / kSeconds;
    return AtTip({kRadius * std::cos(angle), kRadius * std::sin(angle), 0.2});
  }));
  const double length = 2 * kPi * kRadius * kTurns;
  // A sample less than the time (0.05 %), and the filters' gain at half a hertz (0.9999).
  EXPECT_NEAR(metrics.path_length, length, 1e-3 * length);
  EXPECT_NEAR(metrics.mean_speed, length / kSeconds, 1e-3 * length / kSeconds);
  // At the ends the mirrored time series has a corner: the speed there is some percent off.
  EXPECT_NEAR(metrics.peak_speed, length / kSeconds, 0.06 * length / kSeconds);
  EXPECT_EQ(metrics.movements, 1u);
  EXPECT_NEAR(metrics.economy.value(), 0, 0.01);  // it comes back to where it began
  EXPECT_EQ(metrics.idle, 0);
}

TEST(MotionMetrics, AnglesAndInsertionComeFromTheirOwnAxes) {
  // A second each: pitch by 0.5 rad, insertion by 30 mm and back, roll by 1 rad.
  const MotionMetrics metrics = MeasureMotion(Segments(5, [](double t) {
    MotionVector series = MotionVector::Zero();
    series[kMotionPitch] = 0.5 * MinimumJerk(t - 0.5);
    series[kMotionYaw] = 0.3;
    series[kMotionInsertion] = 0.1 + 0.03 * (MinimumJerk(t - 1.5) - MinimumJerk(t - 2.5));
    series[kMotionRoll] = MinimumJerk(t - 3.5);
    return series;
  }));
  // The low-pass shortens no monotone way, and its overshoot is below a thousandth.
  EXPECT_NEAR(metrics.angular_path, 0.5, 1e-3);
  EXPECT_NEAR(metrics.insertion_path, 0.06, 1e-3 * 0.06 + 1e-5);
  EXPECT_NEAR(metrics.roll_path, 1, 2e-3);
  EXPECT_EQ(metrics.path_length, 0);  // the tip stood still
  EXPECT_FALSE(metrics.economy.has_value());
  EXPECT_FALSE(metrics.smoothness.has_value());
}

/// Insertions reached one after the other, m, by minimum-jerk movements of 0.4 s; then a rest, s. Beyond
/// 0.2 m the tip is at tissue.
struct ShaftMove {
  double to, rest;
};
MotionMetrics AlongTheShaft(const std::vector<ShaftMove>& moves) {
  double seconds = 1;
  for (const ShaftMove& move : moves) seconds += 0.4 + move.rest;
  return MeasureMotion(Segments(seconds, [&moves](double t) {
    double at = 0.1, begin = 0.5;
    for (const ShaftMove& move : moves) {
      at += (move.to - at) * MinimumJerk((t - begin) / 0.4);
      if (t < begin + 0.4 + move.rest) break;
      begin += 0.4 + move.rest;
    }
    MotionVector series = MotionVector::Zero();
    series[kMotionInsertion] = at;
    series[kMotionForce] = at > 0.2 ? 1 : 0;
    return series;
  }));
}

TEST(MotionMetrics, AnOvershootIsAnAdvanceThatIsPartlyTakenBackAtOnce) {
  const auto counts = [](const std::vector<ShaftMove>& moves) {
    const MotionMetrics metrics = AlongTheShaft(moves);
    return std::pair(metrics.advances, metrics.overshoots);
  };
  using Counts = std::pair<std::uint64_t, std::uint64_t>;
  EXPECT_EQ(counts({{0.15, 1}}), Counts(1, 0));
  EXPECT_EQ(counts({{0.15, 0}, {0.145, 1}}), Counts(1, 1));
  EXPECT_EQ(counts({{0.15, 0}, {0.145, 1}, {0.1, 1}}), Counts(1, 1)) << "it leaves later";
  EXPECT_EQ(counts({{0.15, 0}, {0.148, 1}}), Counts(1, 0)) << "2 mm are no correction";
  EXPECT_EQ(counts({{0.15, 1}, {0.145, 1}}), Counts(1, 0)) << "after a rest";
  EXPECT_EQ(counts({{0.15, 0}, {0.12, 1}}), Counts(1, 0)) << "more than half: it came back";
  EXPECT_EQ(counts({{0.15, 0}, {0.126, 1}}), Counts(1, 1)) << "less than half";
  EXPECT_EQ(counts({{0.109, 0}, {0.105, 1}}), Counts(0, 0)) << "9 mm are no advance";
  EXPECT_EQ(counts({{0.21, 0}, {0.205, 1}}), Counts(1, 0)) << "a touch";
  EXPECT_EQ(counts({{0.15, 0}, {0.145, 0}, {0.16, 0}, {0.15, 0.5}, {0.1, 1}, {0.15, 1}}),
            Counts(3, 1))
      << "the second is taken back by two thirds";
}

TEST(MotionMetrics, HandsWorkTogetherWhileOneMovesAndAnotherMovesOrHolds) {
  const std::vector<HandWork> hands = {{{{0, 4}, {6, 7}}, {{9, 12}}}, {{{3, 5}}, {{6.5, 8}}}, {}};
  const WorkTimes times = MeasureWork(hands);
  EXPECT_NEAR(times.any_moves, 6, 1e-12);   // 0 to 5, 6 to 7
  EXPECT_NEAR(times.together, 1.5, 1e-12);  // 3 to 4, 6.5 to 7; two that only hold do not count
  EXPECT_EQ(MeasureWork({}).any_moves, 0);
}

TEST(MotionMetrics, CountsMinimumJerkMovements) {
  constexpr int kCount = 7;
  constexpr double kWay = 0.06, kLength = 0.8;
  const MotionMetrics metrics = MeasureMotion(Segments(
      2 * kCount * kLength, [](double t) { return ThereAndBack(t, kCount, kWay, kLength); }));
  EXPECT_EQ(metrics.movements, static_cast<std::uint64_t>(kCount));
  EXPECT_NEAR(metrics.path_length, kCount * kWay, 2e-3 * kCount * kWay);  // overshoot
  EXPECT_NEAR(metrics.economy.value(), 1, 1e-3);                          // straight lines
  // 15/8 of the mean speed; 10 Hz take off a percent of a movement this quick.
  EXPECT_NEAR(metrics.peak_speed, 1.875 * kWay / kLength, 0.015 * 1.875 * kWay / kLength);
  // Half the time is rest, and of each movement the ends, slower than the threshold.
  EXPECT_GT(metrics.idle, kCount * kLength);
  EXPECT_LT(metrics.idle, 1.15 * kCount * kLength);
}

TEST(MotionMetrics, SlowDriftDoesNotCountAsMovement) {
  const MotionMetrics metrics = MeasureMotion(Segments(5, [](double t) {
    return AtTip({0.9 * kIdleSpeed * t, 0, 0});
  }));
  EXPECT_EQ(metrics.movements, 0u);
  EXPECT_NEAR(metrics.idle, metrics.time, 1e-12);
}

// The spectrum of 30 s^2 (1 - s)^2 by quadrature, independent of the sampled one.
double MinimumJerkArcLength() {
  const auto amplitude = [](double cycles) {  // per movement time
    double re = 0, im = 0;
    constexpr int kSteps = 4000;
    for (int i = 0; i < kSteps; ++i) {
      const double s = (i + 0.5) / kSteps;
      const double v = 30 * s * s * (1 - s) * (1 - s) / kSteps;
      re += v * std::cos(2 * kPi * cycles * s);
      im += v * std::sin(2 * kPi * cycles * s);
    }
    return std::hypot(re, im);
  };
  constexpr double kStep = 1e-3;
  double edge = 0;
  for (double f = 0; f < 10; f += 0.01) {
    if (amplitude(f) >= kSparcAmplitude) edge = f;
  }
  double length = 0, last = 1;
  for (double x = kStep; x <= 1 + kStep / 2; x += kStep) {
    const double now = amplitude(x * edge);
    length += std::hypot(kStep, now - last);
    last = now;
  }
  return -length;
}

TEST(SpectralArcLength, DependsOnNeitherLengthNorSizeOfAMinimumJerkMovement) {
  const double exact = MinimumJerkArcLength();
  EXPECT_NEAR(exact, -1.4, 0.05);  // as Balasubramanian et al. (2015) plot it
  for (const double length : {0.6, 1.0, 2.5}) {
    for (const double size : {0.01, 0.2}) {
      std::vector<double> speeds;
      for (double t = kMotionPeriod / 2; t < length; t += kMotionPeriod) {
        const double s = t / length;
        speeds.push_back(size * 30 * s * s * (1 - s) * (1 - s) / length);
      }
      EXPECT_NEAR(SpectralArcLength(speeds, kMotionPeriod), exact, 0.01)  // the edge's bin
          << length << " s, " << size << " m";
    }
  }
}

TEST(MotionMetrics, ASlowMovementIsAsSmoothAsAQuickOne) {
  const double exact = MinimumJerkArcLength();
  for (const double length : {0.8, 1.0, 2.5}) {
    for (const double peak : {0.0105, 0.02, 0.05, 0.3}) {  // of v, m/s
      const double way = peak * length / 1.875;
      const MotionMetrics metrics = MeasureMotion(
          Segments(4 * length, [=](double t) { return ThereAndBack(t, 1, way, length); }));
      ASSERT_EQ(metrics.movements, 1u);
      // The edge's bin, the low-pass, and the step of 1 % that remains; cut at 5 mm/s the slowest
      // has -1.9.
      EXPECT_NEAR(metrics.smoothness.value(), exact, 0.04) << length << " s, " << peak << " m/s";
    }
  }
}

TEST(SpectralArcLength, FallsWithEveryStop) {
  double last = 0;
  for (const int parts : {1, 2, 4}) {
    std::vector<double> speeds;
    for (double t = 0; t < 2; t += kMotionPeriod) {
      const double s = std::fmod(t * parts / 2, 1);
      speeds.push_back(s * s * (1 - s) * (1 - s));
    }
    const double now = SpectralArcLength(speeds, kMotionPeriod);
    EXPECT_LT(now, last - 0.5);
    last = now;
  }
}

// A hand's time series through the device's kinematics, exact or as its encoders have it.
MotionVector ThroughDevice(double t, bool encoded) {
  static const ImpulseEngineKinematics device({0, 0, 0.2}, {0, 0, -1}, DeviceProfile());
  const double reach = MinimumJerk(std::fmod(t, 2) / 1.2);
  JointVector joints = JointVector::Zero();
  joints[0] = 0.15 * std::sin(0.7 * t) + 0.1 * reach;
  joints[1] = 0.2 * std::cos(0.5 * t);
  joints[2] = 0.15 + 0.02 * std::sin(0.9 * t) + 1e-4 * std::sin(2 * kPi * 9 * t);  // tremor
  if (encoded) joints = device.Quantise(joints);
  MotionVector series = AtTip(device.Forward(joints).translation());
  series.segment<4>(kMotionPitch) = joints.head<4>();
  return series;
}

TEST(MotionMetrics, TheEncodersResolutionAddsLessThanAPercent) {
  const auto measure = [](bool encoded) {
    return MeasureMotion(Segments(20, [=](double t) { return ThroughDevice(t, encoded); }));
  };
  const MotionMetrics exact = measure(false), encoded = measure(true);
  EXPECT_NEAR(encoded.path_length, exact.path_length, 0.01 * exact.path_length);
  EXPECT_NEAR(encoded.angular_path, exact.angular_path, 0.01 * exact.angular_path);
  EXPECT_NEAR(encoded.insertion_path, exact.insertion_path, 0.01 * exact.insertion_path);
  EXPECT_EQ(encoded.movements, exact.movements);
  EXPECT_NEAR(encoded.smoothness.value(), exact.smoothness.value(), 0.05);

  // The filter removes the encoders' steps, which at 1 kHz add a path of their own.
  double raw = 0;
  for (int tick = 1; tick <= 20000; ++tick) {
    raw += (ThroughDevice(tick * kTick, true) - ThroughDevice((tick - 1) * kTick, true))
               .segment<3>(kMotionTip)
               .norm();
  }
  EXPECT_GT(raw, 1.1 * exact.path_length);
}

TEST(MotionMetrics, ATipAtRestBetweenTwoEncoderStepsGoesNowhere) {
  // Every tick falls on one of two neighbouring steps at random: the worst that rest can be.
  std::mt19937 random(3);
  const MotionMetrics metrics = MeasureMotion(Segments(60, [&](double) {
    return AtTip({0, 0, random() % 2 == 0 ? 0 : DeviceProfile().encoder_step});
  }));
  EXPECT_LT(metrics.path_length, 0.01);  // a minute of it; sessions go metres a minute
  EXPECT_EQ(metrics.idle, metrics.time);
  EXPECT_EQ(metrics.movements, 0u);
}

TEST(MotionMetrics, SkippedTicksLeaveNoTrace) {
  std::mt19937 random(5);
  int gap = 0;
  const auto measure = [](const std::function<bool(int)>& keep) {
    return MeasureMotion(Segments(
        20, [](double t) { return ThroughDevice(t, true); }, keep));
  };
  const MotionMetrics all = measure([](int) { return true; });
  const MotionMetrics some = measure([&](int) {
    if (gap == 0 && random() % 30 == 0) gap = 1 + static_cast<int>(random() % 20);
    return gap == 0 || gap-- == 0;
  });
  EXPECT_NEAR(some.path_length, all.path_length, 0.01 * all.path_length);
  EXPECT_EQ(some.movements, all.movements);
}

TEST(MotionMetrics, ForceRatesAreThoseOfASine) {
  constexpr double kForce = 1.5, kHz = 1;
  const MotionMetrics metrics = MeasureMotion(Segments(10, [](double t) {
    MotionVector series = MotionVector::Zero();
    series[kMotionForce] = 2 + kForce * std::sin(2 * kPi * kHz * t);
    return series;
  }));
  const double peak = 2 * kPi * kHz * kForce;
  EXPECT_NEAR(metrics.peak_force_rate, peak, 0.01 * peak);
  EXPECT_NEAR(metrics.mean_force_rate, 2 / kPi * peak, 0.01 * peak);
}

}  // namespace
}  // namespace hpdm
