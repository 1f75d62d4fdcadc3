#include "tools/run/log_space.h"

#include <gtest/gtest.h>

namespace hpdm {
namespace {

TEST(LogSpace, TwoInstrumentsAtAKilohertzFill46MegabytesAMinute) {
  EXPECT_NEAR(60 * LogBytesPerSecond(2, 1000), 46e6, 1e6);
  EXPECT_GT(LogBytesPerSecond(2, 1000), LogBytesPerSecond(1, 1000));
  EXPECT_EQ(LogBytesPerSecond(1, 2000), 2 * LogBytesPerSecond(1, 1000));
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
  EXPECT_NE(LogSpaceRemark(1e6, 0, 1'799'999'999), "");
}

}  // namespace
}  // namespace hpdm
