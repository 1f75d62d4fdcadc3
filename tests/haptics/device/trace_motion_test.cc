#include "haptics/device/trace_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "haptics/device/simulated_hand.h"

namespace hpdm {
namespace {

constexpr Nanoseconds kMillisecond = 1'000'000;

TraceRow Row(Nanoseconds time, double x, double roll = 0, double jaw = 1) {
  TraceRow row;
  row.time_ns = time;
  row.values << x, 2 * x, -x, roll, jaw;
  return row;
}

double X(const TraceMotion& motion, Nanoseconds time, TraceMotion::Cursor* cursor) {
  return motion.At(time, cursor)[0];
}

/// Rows of a smooth hand at x(t) = 20 mm sin(2 pi t), speed up to 126 mm/s, as a recorder of 250 Hz
/// writes a source of 125 Hz: every pose twice, times rounded to the ms with a jitter of 1 ms.
std::vector<TraceRow> TeleoperatedRows() {
  std::mt19937 random(3);
  std::vector<TraceRow> rows;
  for (int i = 0; i < 1000; ++i) {
    const int pair = i / 2;
    const double t = 0.008 * pair;
    const Nanoseconds jitter = static_cast<Nanoseconds>(random() % 3) - 1;
    rows.push_back(
        Row((4 * i + (i > 0 ? jitter : 0)) * kMillisecond, 0.02 * std::sin(2 * M_PI * t)));
  }
  return rows;
}

TEST(TraceMotion, PassesThroughEveryRowThatIsNotARepeat) {
  std::vector<TraceRow> rows;
  for (int i = 0; i < 100; ++i)
    rows.push_back(Row(4 * kMillisecond * i, std::sin(0.3 * i), std::cos(0.2 * i)));
  const TraceMotion motion(rows);
  TraceMotion::Cursor cursor;
  for (const TraceRow& row : rows) {
    EXPECT_LT((motion.At(row.time_ns, &cursor) - row.values).norm(), 1e-15);
  }
  EXPECT_EQ(motion.places().size(), rows.size());
}

TEST(TraceMotion, NeverLeavesTheTwoRowsAndIsNeverTwiceAsFastAsTheirSecant) {
  std::mt19937 random(1);
  std::vector<TraceRow> rows;
  Nanoseconds time = 0;
  for (int i = 0; i < 300; ++i) {
    // The last term keeps neighbours apart: a repeat would be dropped.
    rows.push_back(Row(time, static_cast<double>(random() % 1000) * 1e-3 + i % 2 * 1e-4));
    time += static_cast<Nanoseconds>(1 + random() % 9) * kMillisecond;
  }
  const TraceMotion motion(rows);
  TraceMotion::Cursor cursor;
  const Nanoseconds step = 50'000;
  for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
    const double a = rows[i].values[0], b = rows[i + 1].values[0];
    const double secant = std::abs(b - a) / ToSeconds(rows[i + 1].time_ns - rows[i].time_ns);
    double last = X(motion, rows[i].time_ns, &cursor);
    for (Nanoseconds t = rows[i].time_ns + step; t <= rows[i + 1].time_ns; t += step) {
      const double x = X(motion, t, &cursor);
      ASSERT_GE(x, std::min(a, b));
      ASSERT_LE(x, std::max(a, b));
      // 1e-9: a difference of two values near 1 over 50 us rounds to about 1e-11 / s.
      ASSERT_LE(std::abs(x - last) / ToSeconds(step), 2 * secant + 1e-9);
      last = x;
    }
  }
}

TEST(TraceMotion, VelocityIsContinuousOverRowsRestsGapsAndEnds) {
  std::vector<TraceRow> rows;
  Nanoseconds t = 0;
  double x = 0;
  for (int i = 0; i < 30; ++i) rows.push_back(Row(t += 4 * kMillisecond, x += 1e-4 * (1 + i % 3)));
  for (int i = 0; i < 30; ++i) rows.push_back(Row(t += 4 * kMillisecond, x));  // a rest of 120 ms
  for (int i = 0; i < 30; ++i) rows.push_back(Row(t += 4 * kMillisecond, x -= 2e-4));  // back
  t += 500 * kMillisecond;                                                             // a gap
  for (int i = 0; i < 30; ++i) rows.push_back(Row(t += 4 * kMillisecond, x += 1e-4));
  for (TraceRow& row : rows) row.time_ns -= 4 * kMillisecond;
  const TraceMotion motion(rows);
  EXPECT_EQ(motion.gaps().count, 1u);
  EXPECT_EQ(motion.gaps().longest_ns, 504 * kMillisecond);
  TraceMotion::Cursor cursor;
  const Nanoseconds step = 10'000;
  const auto velocity = [&](Nanoseconds at) {
    return (X(motion, at + step, &cursor) - X(motion, at, &cursor)) / ToSeconds(step);
  };
  double last = velocity(-step);
  for (Nanoseconds at = 0; at < motion.duration() + 5 * step; at += step) {
    const double now = velocity(at);
    // Speeds are up to 75 mm/s and a piece lasts 4 ms, so a cubic within twice the secant is at
    // most 6 secant / h = 112 m/s^2: 1.1 mm/s in a step.
    ASSERT_NEAR(now, last, 1.2e-3) << at;
    last = now;
  }
}

TEST(TraceMotion, RepeatsOfAFastRecorderAreNoStaircase) {
  const TraceMotion motion(TeleoperatedRows());
  TraceMotion::Cursor cursor;
  double slowest = 1, fastest = 0;
  // Around t = 1 s the hand moves at 2 pi 20 mm/s = 126 mm/s, a twentieth of a second within 5 %.
  for (Nanoseconds t = 960 * kMillisecond; t < 1040 * kMillisecond; t += kMillisecond) {
    const double v = (X(motion, t + kMillisecond, &cursor) - X(motion, t, &cursor)) / 1e-3;
    slowest = std::min(slowest, v);
    fastest = std::max(fastest, v);
  }
  // A jitter of 1 ms in 8 ms makes secants between 8/10 and 8/6 of the speed; with the repeats kept
  // the speed would fall to 0 in every other interval.
  EXPECT_GT(slowest, 0.126 * 0.95 * 0.5);
  EXPECT_LT(fastest, 0.126 * 8.0 / 6 * 1.4);
}

TEST(TraceMotion, ARestOfAPauseOrMoreStaysARest) {
  std::vector<TraceRow> rows;
  for (int i = 0; i < 100; ++i)
    rows.push_back(Row(4 * kMillisecond * i, i < 50 ? 0 : 1e-3 * (i - 49)));
  const TraceMotion motion(rows);
  TraceMotion::Cursor cursor;
  EXPECT_EQ(X(motion, 4 * kMillisecond * 49, &cursor), 0)
      << "not creeping ahead of the last repeat";
  EXPECT_GT(X(motion, 4 * kMillisecond * 50, &cursor), 0.9e-3);
}

TEST(TraceMotion, AGapIsBridgedByMinimumJerk) {
  std::vector<TraceRow> rows;
  for (int i = 0; i < 50; ++i) rows.push_back(Row(4 * kMillisecond * i, 0.01));
  const Nanoseconds end = rows.back().time_ns + 1656 * kMillisecond;
  for (int i = 0; i < 50; ++i) rows.push_back(Row(end + 4 * kMillisecond * i, 0.03));
  const TraceMotion motion(rows);
  TraceMotion::Cursor cursor;
  for (int i = 0; i <= 10; ++i) {
    const double x = X(motion, rows[49].time_ns + 1656 * kMillisecond * i / 10, &cursor);
    EXPECT_NEAR(x, 0.01 + 0.02 * MinimumJerk::Position(0.1 * i), 1e-12);
  }
}

TEST(TraceMotion, ASlowRecorderHasNoGaps) {
  std::vector<TraceRow> rows;
  for (int i = 0; i < 50; ++i) rows.push_back(Row(100 * kMillisecond * i, 1e-3 * i));
  const TraceMotion motion(rows);
  EXPECT_EQ(motion.gaps().count, 0u);
  TraceMotion::Cursor cursor;
  // Between rows of an even motion it stays even, to rounding.
  EXPECT_NEAR(X(motion, 2525 * kMillisecond, &cursor), 25.25e-3, 1e-15);
}

TEST(TraceMotion, RollAndJawRepeatOnTheirOwn) {
  // The jaw flickers in its last digit, as an encoder does, while the tip is repeated.
  std::vector<TraceRow> rows = TeleoperatedRows();
  std::vector<TraceRow> flickering = rows;
  for (std::size_t i = 0; i < flickering.size(); ++i) flickering[i].values[kJaw] -= i % 2 * 1e-3;
  const TraceMotion plain(rows), other(flickering);
  TraceMotion::Cursor a, b;
  for (Nanoseconds t = 0; t < plain.duration(); t += kMillisecond) {
    ASSERT_EQ(plain.At(t, &a).head<4>(), other.At(t, &b).head<4>());
  }
}

TEST(TraceMotion, AnyOrderOfTimesGivesTheSameValues) {
  const TraceMotion motion(TeleoperatedRows());
  std::mt19937 random(4);
  TraceMotion::Cursor wandering;
  for (int i = 0; i < 2000; ++i) {
    const Nanoseconds t =
        static_cast<Nanoseconds>(random() % 5000) * kMillisecond - 500 * kMillisecond;
    TraceMotion::Cursor fresh;
    ASSERT_EQ(motion.At(t, &wandering), motion.At(t, &fresh));
  }
}

TEST(TraceMotion, OneRowIsAStill) {
  const TraceMotion motion({Row(0, 0.5, 0.1, 0.2)});
  TraceMotion::Cursor cursor;
  EXPECT_EQ(motion.duration(), 0);
  for (const Nanoseconds t : {-kMillisecond, Nanoseconds{0}, kMillisecond}) {
    EXPECT_EQ(motion.At(t, &cursor), Row(0, 0.5, 0.1, 0.2).values);
  }
}

}  // namespace
}  // namespace hpdm
