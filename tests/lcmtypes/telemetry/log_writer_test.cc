#include "lcmtypes/telemetry/log_writer.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "tests/support/read_file.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/telemetry_fixture.h"

namespace hpdm {
namespace {

const std::vector<std::string> kTwoHands = {"left", "right"};

event_t Event(std::int64_t sequence) {
  event_t event{};
  event.sequence = sequence;
  event.name = "test.event";
  event.text = "a test";
  return event;
}

TEST(LogWriter, ReturnsTheBytesThatItAppends) {
  const ScratchFolder folder;
  LogWriter writer({.log_path = folder / "session.lcmlog", .epoch_us = 1000}, kTwoHands);
  const auto bytes = writer.Write(kEventChannel, 5 * kTickPeriod, Event(1));
  const std::vector<std::uint8_t> returned(bytes.begin(), bytes.end());
  writer.Close();
  LogReader reader(folder / "session.lcmlog");
  LogEvent logged;
  ASSERT_TRUE(reader.Next(&logged));
  EXPECT_EQ(logged.channel, kEventChannel);
  EXPECT_EQ(logged.time_us, 6000) << "the epoch and 5 ms";
  EXPECT_EQ(logged.data, returned);
  EXPECT_FALSE(reader.Next(&logged));
}

TEST(LogWriter, FlushesTenTimesASessionSecond) {
  const ScratchFolder folder;
  const std::string log = folder / "session.lcmlog";
  LogWriter writer({.log_path = log}, kTwoHands);
  writer.Write(kEventChannel, 0, Event(1));
  writer.Flush(kNanosecondsPerSecond / 10 - 1);
  EXPECT_EQ(std::filesystem::file_size(log), 0u);
  writer.Flush(kNanosecondsPerSecond / 10);
  const auto flushed = std::filesystem::file_size(log);
  EXPECT_GT(flushed, 0u);
  writer.Write(kEventChannel, 0, Event(2));
  writer.Flush(kNanosecondsPerSecond / 5 - 1);
  EXPECT_EQ(std::filesystem::file_size(log), flushed);
  writer.Flush(kNanosecondsPerSecond / 5);
  EXPECT_EQ(std::filesystem::file_size(log), 2 * flushed);
}

TEST(LogWriter, TheTimelineHoldsEveryTenthTick) {
  const ScratchFolder folder;
  const LogWriter::Options options{.log_path = folder / "session.lcmlog",
                                   .timeline_path = folder / "timeline.csv",
                                   .timeline_interval = 10 * kTickPeriod};
  LogWriter writer(options, kTwoHands);
  for (std::uint64_t tick = 0; tick < 1000; ++tick) writer.Add(Sample(tick, 0));
  writer.Close();
  EXPECT_EQ(writer.TimelineFailure(), "");
  std::istringstream file(ReadFile(options.timeline_path));
  std::string line;
  ASSERT_TRUE(std::getline(file, line));
  EXPECT_EQ(line,
            "t,left_force,left_fx,left_fy,left_fz,left_depth,left_x,left_y,left_z,left_contact,"
            "right_force,right_fx,right_fy,right_fz,right_depth,right_x,right_y,right_z,"
            "right_contact");
  for (std::uint64_t row = 0; row < 100; ++row) {
    ASSERT_TRUE(std::getline(file, line));
    std::vector<double> values;
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) values.push_back(std::stod(cell));
    ASSERT_EQ(values.size(), 19u);
    const HapticSample sample = Sample(10 * row, 0);
    const ToolSample& right = sample.tools[1];
    // Nine significant digits of numbers below 2.
    EXPECT_NEAR(values[0], 0.01 * static_cast<double>(row), 1e-9);
    EXPECT_NEAR(values[10], right.force_W.norm(), 1e-8);
    EXPECT_NEAR(values[13], right.force_W.z(), 1e-8);
    EXPECT_NEAR(values[17], right.p_tip_W.z(), 1e-8);
    EXPECT_EQ(values[18], right.kind == ContactKind::kNone ? 0 : 1);
  }
  EXPECT_FALSE(std::getline(file, line));
}

// A full disk under one file does not stop the other.
TEST(LogWriter, AFailedFileIsReportedAndTheOtherContinues) {
  if (access("/dev/full", W_OK) != 0) GTEST_SKIP() << "no /dev/full here";
  const ScratchFolder folder;
  for (const bool log_fails : {true, false}) {
    const std::string log = log_fails ? "/dev/full" : folder / "session.lcmlog";
    const std::string timeline = log_fails ? folder / "timeline.csv" : "/dev/full";
    LogWriter writer({.log_path = log, .timeline_path = timeline, .timeline_interval = kTickPeriod},
                     kTwoHands);
    for (std::uint64_t tick = 0; tick < 200; ++tick) {
      const Nanoseconds now = static_cast<Nanoseconds>(tick) * kTickPeriod;
      EXPECT_FALSE(writer.Write(kEventChannel, now, Event(1)).empty());
      writer.Add(Sample(tick, 0));
      writer.Flush(now);
    }
    writer.Close();
    EXPECT_EQ(writer.state().failure, log_fails ? LogFailure::kWrite : LogFailure::kNone);
    EXPECT_EQ(writer.state().events + writer.state().dropped, 200u);
    EXPECT_EQ(writer.state().events, log_fails ? 0u : 200u);
    EXPECT_EQ(writer.TimelineFailure().empty(), log_fails);
  }
}

TEST(LogWriter, AFolderThatDoesNotExistIsAnInputError) {
  const ScratchFolder folder;
  EXPECT_THROW(LogWriter({.log_path = folder / "no/session.lcmlog"}, kTwoHands), InputError);
  EXPECT_THROW(LogWriter({.log_path = folder / "session.lcmlog",
                          .timeline_path = folder / "no/timeline.csv",
                          .timeline_interval = kTickPeriod},
                         kTwoHands),
               InputError);
}

}  // namespace
}  // namespace hpdm
