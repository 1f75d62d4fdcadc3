#include "tools/run/log_space.h"

#include <gtest/gtest.h>

namespace hpdm {
namespace {

TEST(LogSpace, TwoInstrumentsAtAKilohertzFill46MegabytesAMinute) {
  EXPECT_NEAR(60 * LogBytesPerSecond(2, 1000, 1), 46e6, 1e6);
  EXPECT_NEAR(60 * LogBytesPerSecond(1, 1000, 1), 34e6, 1e6);
  const double ticks = LogBytesPerSecond(1, 1000, 1) - LogBytesPerSecond(1, 500, 1);
  EXPECT_NEAR(LogBytesPerSecond(1, 2000, 1) - LogBytesPerSecond(1, 1000, 1), 2 * ticks, 1e-6);
}

// The outputs of a tick are half of its bytes.
TEST(LogSpace, AThinnedLogKeepsItsInputs) {
  EXPECT_NEAR(60 * LogBytesPerSecond(2, 1000, 10), 29e6, 1e6);
  EXPECT_NEAR(60 * LogBytesPerSecond(2, 1000, 100), 23e6, 1e6);
  EXPECT_GT(LogBytesPerSecond(2, 1000, 1000), 1000 * (103 + 2 * 102));
}

TEST(LogSpace, ADiskThatHoldsTheWholeLogIsNotMentioned) {
  EXPECT_EQ(LogSpaceRemark(1e6, 60, 60'000'000), "");
  EXPECT_EQ(LogSpaceRemark(1e6, 0, 1'800'000'000), "") << "half an hour of an open session";
}

TEST(LogSpace, ADiskThatIsTooSmallIsNamedWithTheTimeItLasts) {
  const std::string remark = LogSpaceRemark(1e6, 1200, 600'000'000);
  EXPECT_NE(remark.find("600 MB free"), std::string::npos) << remark;
  EXPECT_NE(remark.find("about 10 min"), std::string::npos) << remark;
  EXPECT_NE(remark.find("60 MB a minute"), std::string::npos) << remark;
  EXPECT_NE(remark.find("not for 20 min"), std::string::npos) << remark;
  EXPECT_NE(remark.find("--out"), std::string::npos) << remark;
  EXPECT_NE(remark.find("--log-rate"), std::string::npos) << remark;
  EXPECT_NE(LogSpaceRemark(1e6, 0, 1'799'999'999), "");
}

TEST(LogSpace, ALengthIsRoundedToSecondsOrMinutes) {
  const std::string brief = LogSpaceRemark(1e6, 5, 541'000);
  EXPECT_NE(brief.find("about 0.54 s of"), std::string::npos) << brief;
  EXPECT_NE(brief.find("not for 5 s;"), std::string::npos) << brief;
  const std::string middle = LogSpaceRemark(1e6, 90, 45'678'000);
  EXPECT_NE(middle.find("about 46 s of"), std::string::npos) << middle;
  EXPECT_NE(middle.find("not for 90 s;"), std::string::npos) << middle;
  const std::string open = LogSpaceRemark(1e6, 0, 555'555'000);
  EXPECT_NE(open.find("about 9 min of"), std::string::npos) << open;
}

}  // namespace
}  // namespace hpdm
