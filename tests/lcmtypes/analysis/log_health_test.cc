#include "lcmtypes/analysis/log_health.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <random>
#include <set>

#include "engine/base/error.h"
#include "lcmtypes/log/log.h"
#include "lcmtypes/wire/codec.h"
#include "tests/support/program.h"
#include "tests/support/read_file.h"
#include "tests/support/scratch_folder.h"
#include "tools/log/log_export.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;

class LogHealthTest : public testing::Test {
 protected:
  template <typename Message>
  void Write(SessionLog* log, const char* channel, Nanoseconds time, const Message& message) {
    log->Write(channel, time, EncodeMessage(message, &buffer_));
  }

  void WriteEvent(SessionLog* log, std::int64_t sequence, const std::string& name) {
    event_t event{};
    event.sequence = sequence;
    event.name = name;
    Write(log, kEventChannel, 0, event);
  }

  void WriteTick(SessionLog* log, std::int64_t sequence) {
    tool_t tool{};
    tool.sequence = sequence;
    tool.tick = sequence;
    tool.tool_count = 1;
    tool.tools.resize(1);
    tool.tools[0].joints[2] = 0.1;
    Write(log, kToolChannel, sequence * 1'000'000, tool);
  }

  // A closed session of ticks 1..`ticks` without those that `lost` names.
  void WriteSession(int ticks, const std::function<bool(int)>& lost = nullptr) {
    SessionLog log(log_, 0);
    WriteEvent(&log, 1, "session.start");
    for (int tick = 1; tick <= ticks; ++tick) {
      if (!lost || !lost(tick)) WriteTick(&log, tick);
    }
    WriteEvent(&log, 2, "session.end");
  }

  LogHealth Health() const { return CheckLog(log_, MessageSchemas::Hpdm()); }

  const ScratchFolder folder_;
  const std::string log_ = folder_ / "session.lcmlog";
  std::vector<std::uint8_t> buffer_;
};

TEST_F(LogHealthTest, AWholeSessionIsSound) {
  WriteSession(100);
  const LogHealth health = Health();
  EXPECT_TRUE(health.Sound());
  EXPECT_TRUE(health.session && health.closed);
  ASSERT_EQ(health.channels.size(), 2u);
  const ChannelFacts& tool = health.channels[1];
  EXPECT_EQ(tool.channel, "HPDM_TOOL");
  EXPECT_EQ(tool.type, "hpdm.tool_t");
  EXPECT_EQ(tool.messages, 100u);
  EXPECT_DOUBLE_EQ(tool.Rate(), 1000);
}

TEST_F(LogHealthTest, MissingMessagesAreCountedByTheirSequence) {
  WriteSession(100, [](int tick) { return tick == 10 || (tick >= 50 && tick < 57); });
  const LogHealth health = Health();
  EXPECT_FALSE(health.Sound());
  EXPECT_EQ(health.channels[1].gaps, 2u);
  EXPECT_EQ(health.channels[1].lost, 8u);
}

TEST_F(LogHealthTest, RepeatedAndReversedMessagesAreCounted) {
  {
    SessionLog log(log_, 0);
    for (const int tick : {1, 2, 2, 4, 3, 5}) WriteTick(&log, tick);
  }
  EXPECT_EQ(Health().channels[0].not_rising, 2u);
  EXPECT_EQ(Health().channels[0].lost, 1u);
}

TEST_F(LogHealthTest, DriversOfTwoInstrumentsCountForThemselves) {
  {
    SessionLog log(log_, 0);
    for (int i = 0; i < 10; ++i) {
      device_t device{};
      device.instrument = i % 2;
      device.sequence = 100 * (i % 2) + i / 2;
      Write(&log, kDeviceChannel, 0, device);
    }
  }
  EXPECT_TRUE(Health().Sound());
}

TEST_F(LogHealthTest, ATornTailIsReportedAndCut) {
  WriteSession(20);
  const std::uintmax_t size = fs::file_size(log_);
  fs::resize_file(log_, size - 5);
  const LogHealth torn = Health();
  EXPECT_FALSE(torn.Sound());
  EXPECT_FALSE(torn.closed);  // its last event is gone
  EXPECT_GT(torn.torn_bytes, 0u);
  EXPECT_EQ(torn.damaged_bytes, 0u);

  const std::string mended = folder_ / "mended.lcmlog";
  EXPECT_EQ(RepairLog(log_, mended), torn.events);
  const LogHealth health = CheckLog(mended, MessageSchemas::Hpdm());
  EXPECT_EQ(health.torn_bytes, 0u);
  EXPECT_EQ(health.events, torn.events);
  EXPECT_EQ(health.channels[1].messages, 20u);
  EXPECT_EQ(health.channels[1].last_us, torn.channels[1].last_us);
  EXPECT_THROW(RepairLog(log_, mended), InputError);  // nothing is overwritten
}

TEST_F(LogHealthTest, DamageInTheMiddleIsReportedAndLeftOut) {
  WriteSession(20);
  {
    std::fstream file(log_, std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(static_cast<std::streamoff>(fs::file_size(log_) / 2));
    file.write("damage damage damage damage damage damage damage", 48);
  }
  const LogHealth health = Health();
  EXPECT_FALSE(health.Sound());
  const std::string mended = folder_ / "mended.lcmlog";
  RepairLog(log_, mended);
  const LogHealth after = CheckLog(mended, MessageSchemas::Hpdm());
  EXPECT_EQ(after.damaged_bytes, 0u);
  EXPECT_EQ(after.events, health.events);
}

TEST_F(LogHealthTest, ForeignAndUnreadableMessagesAreReported) {
  {
    SessionLog log(log_, 0);
    log.Write("FOREIGN", 0, std::vector<std::uint8_t>{1, 2, 3, 4, 5, 6, 7, 8, 9});
    log.Write("SHORT", 0, std::vector<std::uint8_t>{1});
    WriteTick(&log, 1);
    std::vector<std::uint8_t> bytes(buffer_);
    bytes.pop_back();
    log.Write(kToolChannel, 0, bytes);
  }
  const LogHealth health = Health();
  EXPECT_EQ(health.channels[0].type, "0x0102030405060708");
  EXPECT_FALSE(health.channels[0].known);
  EXPECT_EQ(health.channels[1].unreadable, 1u);
  EXPECT_EQ(health.channels[2].type, "no LCM message");
}

TEST_F(LogHealthTest, EveryPrefixAndEveryFlippedByteIsReadToItsEnd) {
  WriteSession(3);
  const std::string whole = ReadFile(log_);
  const auto check = [&](const std::string& bytes) {
    std::ofstream(log_, std::ios::binary) << bytes;
    const LogHealth health = Health();
    EXPECT_LE(health.damaged_bytes + health.torn_bytes, bytes.size());
    const std::string mended = folder_ / "mended.lcmlog";
    fs::remove(mended);
    RepairLog(log_, mended);
    EXPECT_EQ(CheckLog(mended, MessageSchemas::Hpdm()).events, health.events);
  };
  for (std::size_t size = 0; size < whole.size(); ++size) check(whole.substr(0, size));
  std::mt19937 random(1);
  for (int i = 0; i < 300; ++i) {
    std::string flipped = whole;
    flipped[random() % flipped.size()] ^= static_cast<char>(1 + random() % 255);
    check(flipped);
  }
}

TEST_F(LogHealthTest, TablesHoldEveryValueExactly) {
  WriteSession(3);
  const auto exported = ExportCsv(log_, folder_.path() / "csv", {}, MessageSchemas::Hpdm());
  ASSERT_EQ(exported.size(), 2u);
  EXPECT_EQ(exported[1].messages, 3u);
  std::ifstream table(exported[1].file);
  std::string header, row;
  std::getline(table, header);
  std::getline(table, row);
  EXPECT_TRUE(header.starts_with("time_us,tool_count,sequence,tick")) << header;
  EXPECT_NE(header.find("tools[0].joints[2]"), std::string::npos);
  EXPECT_TRUE(row.starts_with("1000,1,1,1,")) << row;
  EXPECT_NE(row.find(",0.1,"), std::string::npos) << row;
  EXPECT_EQ(ReadFile(folder_.path() / "csv" / "HPDM_EVENT.csv").find("time_us,sequence"), 0u);
}

TEST_F(LogHealthTest, ArraysThatGrowGetTheColumnsOfTheLongest) {
  {
    SessionLog log(log_, 0);
    for (const int count : {1, 2, 1}) {
      tool_t tool{};
      tool.tool_count = count;
      tool.tools.resize(static_cast<std::size_t>(count));
      Write(&log, kToolChannel, 0, tool);
    }
  }
  const auto exported = ExportCsv(log_, folder_.path() / "csv", {}, MessageSchemas::Hpdm());
  std::ifstream table(exported[0].file);
  std::string line;
  std::getline(table, line);
  const auto columns = std::count(line.begin(), line.end(), ',');
  EXPECT_LT(line.find("tools[0].device_valid"), line.find("tools[1].joints[0]"));
  while (std::getline(table, line)) EXPECT_EQ(std::count(line.begin(), line.end(), ','), columns);
}

TEST_F(LogHealthTest, ARepairKeepsEveryTimeStamp) {
  {
    SessionLog log(log_, 0);
    const std::vector<std::uint8_t> data = {1};
    for (const std::int64_t time_us :
         {std::int64_t{5}, std::int64_t{9'000'000'000'000'000'000}, std::int64_t{3}}) {
      log.Append("A", time_us, data);
    }
  }
  const std::string mended = folder_ / "mended.lcmlog";
  EXPECT_EQ(RepairLog(log_, mended), 3u);
  EXPECT_EQ(ReadFile(mended), ReadFile(log_));
}

TEST_F(LogHealthTest, NumbersAtBothEndsOfTheirRangeAreCounted) {
  {
    SessionLog log(log_, 0);
    tool_t tool{};
    for (const std::int64_t sequence :
         {std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::min(),
          std::numeric_limits<std::int64_t>::max()}) {
      tool.sequence = sequence;
      Write(&log, kToolChannel, 0, tool);
    }
  }
  EXPECT_EQ(Health().channels[0].gaps, 1u);
  EXPECT_EQ(Health().channels[0].not_rising, 1u);
}

TEST(ChannelFacts, ARateOverTheWholeRangeOfStampsIsFinite) {
  ChannelFacts facts;
  facts.messages = 3;
  facts.first_us = std::numeric_limits<std::int64_t>::min();
  facts.last_us = std::numeric_limits<std::int64_t>::max();
  EXPECT_NEAR(facts.Rate(), 2e6 / std::ldexp(1.0, 64), 1e-20);  // of rounding
}

TEST_F(LogHealthTest, ChannelsOfLikeNamesGetTablesOfTheirOwn) {
  {
    SessionLog log(log_, 0);
    event_t event{};
    for (const char* channel : {"A.1", "A_1", "A 1"}) Write(&log, channel, 0, event);
  }
  const auto exported = ExportCsv(log_, folder_.path() / "csv", {}, MessageSchemas::Hpdm());
  std::set<fs::path> files;
  for (const ExportedChannel& channel : exported) files.insert(channel.file);
  EXPECT_EQ(files.size(), 3u);
}

TEST_F(LogHealthTest, MoreChannelsThanFilesMayBeOpenAndLongNamesGetWholeTables) {
  const std::string long_name(300, 'x');
  constexpr int kChannels = 300;
  {
    SessionLog log(log_, 0);
    event_t event{};
    Write(&log, (long_name + "1").c_str(), 0, event);
    Write(&log, (long_name + "2").c_str(), 0, event);
    for (int i = 0; i < 3 * kChannels; ++i) {
      Write(&log, std::to_string(i % kChannels).c_str(), i * 1000, event);
    }
  }
  rlimit before;
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &before), 0);
  rlimit few = before;
  few.rlim_cur = 128;
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &few), 0);
  const auto exported = ExportCsv(log_, folder_.path() / "csv", {}, MessageSchemas::Hpdm());
  setrlimit(RLIMIT_NOFILE, &before);
  ASSERT_EQ(exported.size(), kChannels + 2u);
  std::set<fs::path> files;
  for (const ExportedChannel& channel : exported) {
    files.insert(channel.file);
    const std::string text = ReadFile(channel.file);
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), channel.channel[0] == 'x' ? 2 : 4);
    EXPECT_TRUE(text.starts_with("time_us,"));
  }
  EXPECT_EQ(files.size(), exported.size());
}

TEST_F(LogHealthTest, AChannelThatIsNotThereIsRefusedAndNamesStayInTheFolder) {
  {
    SessionLog log(log_, 0);
    event_t event{};
    Write(&log, "../../evil", 0, event);
  }
  EXPECT_THROW(ExportCsv(log_, folder_.path() / "csv", {"NONE"}, MessageSchemas::Hpdm()),
               InputError);
  const auto exported = ExportCsv(log_, folder_.path() / "csv", {}, MessageSchemas::Hpdm());
  EXPECT_EQ(exported[0].file, folder_.path() / "csv" / "______evil.csv");
}

TEST_F(LogHealthTest, ATableReplacesALinkAndNeverWhatItLeadsTo) {
  {
    SessionLog log(log_, 0);
    event_t event{};
    Write(&log, "evil", 0, event);
  }
  const fs::path folder = folder_.path() / "csv", table = folder / "evil.csv";
  fs::create_directory(folder);
  std::ofstream(folder_.path() / "victim") << "precious";
  fs::create_symlink("../victim", table);
  ExportCsv(log_, folder, {}, MessageSchemas::Hpdm());
  EXPECT_EQ(ReadFile(folder_.path() / "victim"), "precious");
  EXPECT_FALSE(fs::is_symlink(table));
  EXPECT_TRUE(ReadFile(table).starts_with("time_us,"));

  fs::remove(table);
  ASSERT_EQ(mkfifo(table.c_str(), 0600), 0);  // would wait for a reader for ever
  EXPECT_THROW(ExportCsv(log_, folder, {}, MessageSchemas::Hpdm()), InputError);
}

TEST_F(LogHealthTest, NamesReachATerminalEscaped) {
  {
    SessionLog log(log_, 0);
    event_t event{};
    Write(&log, "\x1b]0;title\x07", 0, event);
    log.Write("\x1b[2J", 0, std::vector<std::uint8_t>(8));  // of no known type
  }
  const std::string out = folder_ / "told";
  EXPECT_EQ(Shell(kHpdmProgram + " log check " + log_ + " >" + out + " 2>&1"), 0);
  const std::string reported = ReadFile(out);
  EXPECT_NE(reported.find("?]0;title?"), std::string::npos) << reported;
  EXPECT_EQ(reported.find('\x1b'), std::string::npos);
  EXPECT_EQ(Shell(kHpdmProgram + " log export " + log_ + " --out " + (folder_ / "csv") + " >" +
                  out + " 2>&1"),
            0);
  EXPECT_EQ(ReadFile(out).find('\x1b'), std::string::npos);
}

}  // namespace
}  // namespace hpdm
