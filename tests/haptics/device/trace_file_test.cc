#include "haptics/device/trace_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <numbers>

#include "engine/base/error.h"
#include "tests/support/scratch_folder.h"

namespace hpdm {
namespace {

class TraceFileTest : public testing::Test {
 protected:
  TraceFile Read(const std::string& text) const {
    std::ofstream(folder_ / "t.csv", std::ios::binary) << text;
    return ReadTraceFile(folder_ / "t.csv");
  }
  /// Returns the message without the folder; empty if the trace is sound.
  std::string Error(const std::string& text) const {
    try {
      Read(text);
    } catch (const InputError& error) {
      const std::string message = error.what();
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
      return message.substr(folder_.path().string().size() + 1);
    }
    return "";
  }

  ScratchFolder folder_;
};

TEST_F(TraceFileTest, RowsComeAsTheyAreWithTimesFromTheFirst) {
  const TraceFile file = Read("t,px,py,pz,jaw\n5.5,1,2,3,0.25\n5.504,-1,2.5e-1,+3,1\n");
  EXPECT_EQ(file.place, TracePlace::kTip);
  ASSERT_EQ(file.rows.size(), 2u);
  EXPECT_EQ(file.rows[0].time_ns, 0);
  EXPECT_EQ(file.rows[0].values, (JointVector() << 1, 2, 3, 0, 0.25).finished());
  EXPECT_EQ(file.rows[1].time_ns, 4'000'000);
  EXPECT_EQ(file.rows[1].values, (JointVector() << -1, 0.25, 3, 0, 1).finished());
}

TEST_F(TraceFileTest, ColumnsMayComeInAnyOrderAndUnknownOnesAreReportedAndNotRead) {
  const TraceFile file = Read("roll,note,insertion,yaw,pitch,t\n0.5,?,0.1,0.2,0.3,0\n");
  EXPECT_EQ(file.place, TracePlace::kJoints);
  EXPECT_EQ(file.rows[0].values, (JointVector() << 0.3, 0.2, 0.1, 0.5, 1).finished());
  EXPECT_EQ(file.unread_columns, std::vector<std::string>{"\"note\""});
}

TEST_F(TraceFileTest, ByteOrderMarkCrlfSpacesCommentsAndAMissingLastLineEndAreTaken) {
  const TraceFile file =
      Read("\xEF\xBB\xBF# a trace\r\n t , px,py,pz\r\n\r\n0, 1,2 ,3\r\n% pause\r\n1,1,2,3");
  ASSERT_EQ(file.rows.size(), 2u);
  EXPECT_EQ(file.rows[1].time_ns, kNanosecondsPerSecond);
  EXPECT_EQ(file.rows[0].values[kJaw], 1) << "open, so that it does not grasp";
}

TEST_F(TraceFileTest, TheLastOfRowsWithTheSameTimeCounts) {
  const TraceFile file = Read("t,roll\n0,0\n1,0.1\n1,0.2\n2,0.3\n");
  ASSERT_EQ(file.rows.size(), 3u);
  EXPECT_EQ(file.rows[1].values[kRoll], 0.2);
}

TEST_F(TraceFileTest, AWrappedRollIsUnwrapped) {
  std::string text = "t,roll\n";
  for (int i = 0; i < 300; ++i) {
    text += std::to_string(i) + "," +
            std::to_string(std::remainder(0.1 * i, 2 * std::numbers::pi)) + "\n";
  }
  const TraceFile file = Read(text);
  for (int i = 0; i < 300; ++i) {
    // Written with six decimals.
    ASSERT_NEAR(file.rows[static_cast<std::size_t>(i)].values[kRoll], 0.1 * i, 1e-6);
  }
}

TEST_F(TraceFileTest, EveryFaultIsOneLineWithItsPlaceAndRemedy) {
  const struct {
    std::string text, error;
  } cases[] = {
      {"", "t.csv: the file is empty; give a header such as t,px,py,pz,jaw and rows"},
      {"\n# nothing\n", "t.csv:2: the file is empty"},
      {"t,px,py,pz\n", "t.csv:1: has no rows; give at least one row"},
      {"0,1,2,3\n", "t.csv:1: the columns are not named (\"0\"); begin with a line such as"},
      {"t;px;py;pz\n0;1;2;3\n", "t.csv:1: is separated by semicolons; separate cells by commas"},
      {"time,px,py,pz\n0,1,2,3\n", "t.csv:1: has no column t; "},
      {"t,px,py\n0,1,2\n", "t.csv:1: has incomplete or mixed position columns; give px, py and pz"},
      {"t,px,py,pz,pitch\n0,1,2,3,4\n", "t.csv:1: has incomplete or mixed position columns"},
      {"t,px,py,pz,pitch,yaw,insertion\n0,1,2,3,4,5,6\n",
       "t.csv:1: has incomplete or mixed position columns"},
      {"t,force\n0,1\n", "t.csv:1: has no column that moves"},
      {"t,px,py,pz,px\n0,1,2,3,4\n", "t.csv:1: names px twice"},
      {"t,px,py,pz\n0,1,2,3\n1,1,2\n", "t.csv:3: has 3 cells where the header names 4"},
      {"t,px,py,pz\n0,1,5,2,3\n",
       "t.csv:2: has 5 cells where the header names 4; separate cells by "
       "single commas and write numbers with a decimal point"},
      {"t,px,py,pz\n0,1,2,nan\n", "t.csv:2: pz is not a finite number (\"nan\"); write it as"},
      {"t,px,py,pz\ninf,1,2,3\n", "t.csv:2: t is not a finite number (\"inf\")"},
      {"t,px,py,pz\n0,1,,3\n", "t.csv:2: py is not a finite number (\"\")"},
      {"t,px,py,pz\n0,1,0x10,3\n", "t.csv:2: py is not a finite number (\"0x10\")"},
      {"t,px,py,pz\n0,1,2 3,3\n", "t.csv:2: py is not a finite number (\"2 3\")"},
      {"t,px,py,pz\n0,1,1e999,3\n", "t.csv:2: py is not a finite number"},
      {"t,px,py,pz\n0,1,2e5,3\n", "t.csv:2: py is beyond any pose (\"2e5\"); give metres"},
      {"t,px,py,pz\n1,1,2,3\n0.5,1,2,3\n", "t.csv:3: time goes backwards; sort the rows"},
      {"t,px,py,pz\n0,1,2,3\n1e6,1,2,3\n", "t.csv:3: t is more than a day after the first row"},
      {"t,px,py,pz\n0,1,2,3\n" + std::string(5000, '1'), "t.csv:3: is longer than 4096 bytes"},
      {std::string("t,px,py,pz\n0,1,\0,3\n", 19), "t.csv:2: py is not a finite number (\"?\")"},
      {"t,px,py,pz\n0,1,\x1b[2J" + std::string(99, 'x') + ",3\n",
       "t.csv:2: py is not a finite number (\"?[2Jxxxxxxxxxxxxxxxxxxxx...\")"},
      {std::string("\xFF\xFEt\0,\0", 6), "t.csv:1: is UTF-16; save it as UTF-8"},
  };
  for (const auto& [text, error] : cases) {
    EXPECT_TRUE(Error(text).starts_with(error)) << Error(text) << "\n  instead of\n" << error;
  }
}

TEST_F(TraceFileTest, AMissingOrSpecialFileIsAnInputError) {
  EXPECT_THROW(ReadTraceFile(folder_ / "missing.csv"), InputError);
  EXPECT_THROW(ReadTraceFile(folder_.path().string()), InputError);
  EXPECT_THROW(ReadTraceFile("/dev/zero"), InputError) << "it has no end";
}

TEST_F(TraceFileTest, NoCutOrFlippedByteCrashesOrGivesAPoseThatIsNotFinite) {
  std::string sound = "t,px,py,pz,roll,jaw\n";
  for (int i = 0; i < 5; ++i) sound += std::to_string(0.004 * i) + ",0.1,-0.2,0.3,0.5,1\n";
  std::size_t taken = 0;
  const auto check = [&](const std::string& text) {
    try {
      for (const TraceRow& row : Read(text).rows) ASSERT_TRUE(row.values.allFinite());
      ++taken;
    } catch (const InputError&) {
    }
  };
  for (std::size_t size = 0; size < sound.size(); ++size) check(sound.substr(0, size));
  for (std::size_t at = 0; at < sound.size(); at += 3) {
    std::string text = sound;
    text[at] = static_cast<char>(text[at] ^ (1 << at % 8));
    check(text);
  }
  EXPECT_GT(taken, 0u);
}

}  // namespace
}  // namespace hpdm
