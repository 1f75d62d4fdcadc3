#include "engine/threads/wake_up_baseline.h"

#include <gtest/gtest.h>

namespace hpdm {
namespace {

constexpr Nanoseconds kTickPeriod = 1'000'000;

// Wakes the n-th sleep n microseconds late, but every hundredth by two and a half periods.
class LateClock : public LoopClock {
 public:
  Nanoseconds Now() noexcept override { return now_; }
  Nanoseconds ThreadCpuTime() noexcept override { return 0; }
  void SleepUntil(Nanoseconds time) noexcept override {
    ++sleeps_;
    now_ = time + (sleeps_ % 100 == 0 ? 5 * kTickPeriod / 2 : sleeps_ * 1000);
  }

 private:
  Nanoseconds now_ = 0;
  Nanoseconds sleeps_ = 0;
};

TEST(WakeUpBaseline, IsTheLatenessOfEveryTickOfALoopWithNothingToDo) {
  LateClock clock;
  const WakeUpBaseline baseline = MeasureWakeUps({kTickPeriod, kTickPeriod, 102}, {}, clock);
  EXPECT_EQ(baseline.count.Periods(), 102u);
  EXPECT_EQ(baseline.count.ticks, 100u);
  EXPECT_EQ(baseline.count.skipped.late_wake_up, 2u) << "the hundredth sleep missed two periods";
  EXPECT_EQ(baseline.wake_late.count(), 100u);
  EXPECT_EQ(baseline.wake_late.max(), 5 * kTickPeriod / 2)
      << "and is not cut to its tick's own period";
}

TEST(WakeUpBaseline, EndsWhenAsked) {
  LateClock clock;
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(MeasureWakeUps({0, kTickPeriod, 1000}, stop.get_token(), clock).count.Periods(), 0u);
}

}  // namespace
}  // namespace hpdm
