#include "engine/threads/stolen_time.h"

#include <gtest/gtest.h>

namespace hpdm {
namespace {

TEST(StolenTime, IsTheEighthNumberOfTheFirstLine) {
  EXPECT_EQ(StolenTimeIn("cpu  1 2 3 4 5 6 7 1493 9 10\ncpu0 1 2 3 4 5 6 7 800 9 10\n", 100),
            14'930'000'000);
  EXPECT_EQ(StolenTimeIn("cpu  1 2 3 4 5 6 7 3 9 10\n", 250), 12'000'000);
}

TEST(StolenTime, IsZeroWhereTheKernelDoesNotReportIt) {
  EXPECT_EQ(StolenTimeIn("", 100), 0);
  EXPECT_EQ(StolenTimeIn("cpu  1 2 3 4\n", 100), 0) << "kernels before 2.6.11 count no steal";
  EXPECT_EQ(StolenTimeIn("intr 1 2 3 4 5 6 7 8 9", 100), 0);
}

TEST(StolenTime, NeverFallsOnThisMachine) {
  const Nanoseconds before = StolenTime();
  EXPECT_GE(before, 0);
  EXPECT_GE(StolenTime(), before);
}

}  // namespace
}  // namespace hpdm
