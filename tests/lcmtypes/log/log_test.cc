#include "lcmtypes/log/log.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <fstream>
#include <iterator>
#include <lcm/lcm-cpp.hpp>
#include <random>
#include <thread>

#include "engine/base/error.h"
#include "tests/support/network_namespace.h"
#include "tests/support/read_file.h"
#include "tests/support/scratch_folder.h"

namespace hpdm {
namespace {

std::vector<std::uint8_t> Payload(int i) {
  std::vector<std::uint8_t> data(20 + static_cast<std::size_t>(i) % 50);
  for (std::size_t k = 0; k < data.size(); ++k) data[k] = static_cast<std::uint8_t>(i + k);
  return data;
}

std::string Channel(int i) { return i % 2 == 0 ? "HPDM_EVEN" : "HPDM_ODD"; }

/// `count` events, 100 us apart.
void WriteLog(const std::string& path, int count, std::int64_t epoch_us = 0) {
  SessionLog log(path, epoch_us);
  for (int i = 0; i < count; ++i) log.Write(Channel(i).c_str(), i * 100'000, Payload(i));
  log.Close();
  EXPECT_EQ(log.state().failure, LogFailure::kNone);
  EXPECT_EQ(log.state().events, static_cast<std::uint64_t>(count));
}

void WriteBytes(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

/// Checks that the event is number `i` of WriteLog.
void ExpectEvent(const LogEvent& event, int i) {
  EXPECT_EQ(event.number, i);
  EXPECT_EQ(event.time_us, i * 100);
  EXPECT_EQ(event.channel, Channel(i));
  EXPECT_EQ(event.data, Payload(i));
}

TEST(Log, EveryEventComesBackOnceAndInOrder) {
  const ScratchFolder folder;
  WriteLog(folder / "a.lcmlog", 5000);
  LogReader reader(folder / "a.lcmlog");
  LogEvent event;
  for (int i = 0; i < 5000; ++i) {
    ASSERT_TRUE(reader.Next(&event)) << i;
    ExpectEvent(event, i);
  }
  EXPECT_FALSE(reader.Next(&event));
  EXPECT_EQ(reader.damaged_stretches(), 0u);
  EXPECT_EQ(reader.intact_end(), reader.size());
}

TEST(Log, EventsLargerThanTheReadersWindowComeBack) {
  const ScratchFolder folder;
  const std::vector<std::uint8_t> large(3'000'000, 0xED);
  {
    SessionLog log(folder / "a.lcmlog", 0);
    for (int i = 0; i < 3; ++i) {
      log.Write("A", 0, Payload(i));
      log.Write("B", 0, large);
    }
  }
  LogReader reader(folder / "a.lcmlog");
  LogEvent event;
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(reader.Next(&event));
    EXPECT_EQ(event.data, Payload(i));
    ASSERT_TRUE(reader.Next(&event));
    EXPECT_EQ(event.data, large);
  }
  EXPECT_FALSE(reader.Next(&event));
  EXPECT_EQ(reader.damaged_bytes(), 0u);
}

TEST(Log, TimeStampsCountFromTheEpochAndNeverRunBackwards) {
  const ScratchFolder folder;
  {
    SessionLog log(folder / "a.lcmlog", 1'700'000'000'000'000);
    for (Nanoseconds time : {1'000'999, 3'000'000, 2'000'000, 4'000'000}) log.Write("A", time, {});
  }
  LogReader reader(folder / "a.lcmlog");
  LogEvent event;
  for (std::int64_t offset : {1000, 3000, 3000, 4000}) {
    ASSERT_TRUE(reader.Next(&event));
    EXPECT_EQ(event.time_us, 1'700'000'000'000'000 + offset);
  }
}

TEST(Log, LiblcmReadsTheSameEvents) {
  const ScratchFolder folder;
  WriteLog(folder / "a.lcmlog", 100);
  lcm::LogFile file(folder / "a.lcmlog", "r");
  ASSERT_TRUE(file.good());
  for (int i = 0; i < 100; ++i) {
    const lcm::LogEvent* event = file.readNextEvent();
    ASSERT_NE(event, nullptr);
    const auto* data = static_cast<const std::uint8_t*>(event->data);
    ExpectEvent({event->eventnum, event->timestamp, event->channel, {data, data + event->datalen}},
                i);
  }
  EXPECT_EQ(file.readNextEvent(), nullptr);
}

TEST(Log, EveryPrefixReadsAsItsWholeEvents) {
  const ScratchFolder folder;
  constexpr int kEvents = 20;
  WriteLog(folder / "a.lcmlog", kEvents);
  const std::string bytes = ReadFile(folder / "a.lcmlog");
  std::vector<std::size_t> ends;  // of each event
  LogReader whole(folder / "a.lcmlog");
  for (LogEvent event; whole.Next(&event);) ends.push_back(whole.intact_end());
  ASSERT_EQ(ends.size(), static_cast<std::size_t>(kEvents));

  for (std::size_t size = 0; size <= bytes.size(); ++size) {
    WriteBytes(folder / "b.lcmlog", bytes.substr(0, size));
    LogReader reader(folder / "b.lcmlog");
    LogEvent event;
    int count = 0;
    while (reader.Next(&event)) ExpectEvent(event, count++);
    const auto expected = std::upper_bound(ends.begin(), ends.end(), size) - ends.begin();
    ASSERT_EQ(count, expected) << "prefix of " << size << " bytes";
    const std::size_t intact = expected == 0 ? 0 : ends[static_cast<std::size_t>(expected) - 1];
    EXPECT_EQ(reader.intact_end(), intact);
    EXPECT_EQ(reader.damaged_bytes(), size - intact) << "the torn tail";
    EXPECT_FALSE(reader.Next(&event)) << "the end stays the end";
    EXPECT_EQ(reader.damaged_bytes(), size - intact) << "and is counted once";
  }
}

TEST(Log, DamageCostsOnlyTheEventsAroundIt) {
  const ScratchFolder folder;
  WriteLog(folder / "a.lcmlog", 1000);
  const std::string sound = ReadFile(folder / "a.lcmlog");
  std::mt19937 random(7);
  for (int trial = 0; trial < 300; ++trial) {
    std::string bytes = sound;
    bytes[random() % bytes.size()] ^= static_cast<char>(1u << random() % 8);
    WriteBytes(folder / "b.lcmlog", bytes);
    LogReader reader(folder / "b.lcmlog");
    LogEvent event;
    int count = 0, unchanged = 0;
    while (reader.Next(&event)) {
      ++count;
      const auto i = static_cast<int>(event.number);
      if (i < 0 || i >= 1000) continue;
      unchanged +=
          event.time_us == i * 100 && event.channel == Channel(i) && event.data == Payload(i);
    }
    // A flipped sync word hides its own event and the one before, which nothing sound follows.
    EXPECT_GE(unchanged, 998);
    EXPECT_LE(count, 1000);
    EXPECT_LE(reader.damaged_stretches(), 1u);
  }
}

TEST(Log, GarbageEndsReadingWithoutAnEvent) {
  const ScratchFolder folder;
  std::mt19937 random(8);
  std::string bytes(3'000'000, '\0');
  for (char& c : bytes) c = static_cast<char>(random());
  // Headers that claim 2^31 - 1 bytes and a negative length.
  const std::string sync = "\xED\xA1\xDA\x01";
  bytes.replace(1000, 28,
                sync + std::string(16, '\0') + std::string("\0\0\0\4\x7F\xFF\xFF\xFF", 8));
  bytes.replace(2000, 28,
                sync + std::string(16, '\0') + std::string("\0\0\0\4\xFF\xFF\xFF\xFF", 8));
  WriteBytes(folder / "a.lcmlog", bytes);
  LogReader reader(folder / "a.lcmlog");
  LogEvent event;
  EXPECT_FALSE(reader.Next(&event));
  EXPECT_EQ(reader.damaged_stretches(), 1u);
  EXPECT_EQ(reader.damaged_bytes(), bytes.size());
}

TEST(Log, AFileThatIsNotALogIsAnInputError) {
  const ScratchFolder folder;
  EXPECT_THROW(LogReader(folder / "missing"), InputError);
  EXPECT_THROW(LogReader(folder.path().string()), InputError);
  std::ofstream(folder / "a.lcmlog.zst", std::ios::binary) << "\x28\xB5\x2F\xFD and more";
  try {
    LogReader reader(folder / "a.lcmlog.zst");
    ADD_FAILURE() << "a compressed log";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("unpack it with zstd -d"), std::string::npos);
  }
  EXPECT_THROW(SessionLog(folder / "no/such/folder/a.lcmlog", 0), InputError);
}

TEST(Log, AFullDiskIsCountedOnceAndNeverThrown) {
  if (access("/dev/full", W_OK) != 0) GTEST_SKIP() << "no /dev/full here";
  SessionLog log("/dev/full", 0);
  for (int i = 0; i < 100; ++i) log.Write("A", 0, Payload(i));
  log.Flush();
  EXPECT_EQ(log.state().failure, LogFailure::kWrite);
  EXPECT_EQ(log.state().error, ENOSPC);
  EXPECT_EQ(log.state().events, 0u);
  EXPECT_EQ(log.state().dropped, 100u);
  log.Write("A", 0, Payload(0));
  log.Flush();
  log.Close();
  EXPECT_EQ(log.state().dropped, 101u);
  EXPECT_NE(log.state().Explain().find("No space left"), std::string::npos);
}

TEST(Log, ALogThatCannotGrowEndsWithAWholeEvent) {
  const ScratchFolder folder;
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before;
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small = {100'001, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  SessionLog log(folder / "a.lcmlog", 0);
  for (int i = 0; i < 5000; ++i) {
    log.Write(Channel(i).c_str(), i * 100'000, Payload(i));
    if (i % 100 == 99) log.Flush();
  }
  log.Close();
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_EQ(log.state().failure, LogFailure::kWrite);
  EXPECT_EQ(log.state().error, EFBIG);
  EXPECT_EQ(log.state().events + log.state().dropped, 5000u);
  LogReader reader(folder / "a.lcmlog");
  LogEvent event;
  int count = 0;
  while (reader.Next(&event)) ExpectEvent(event, count++);
  EXPECT_EQ(static_cast<std::uint64_t>(count), log.state().events);
  EXPECT_GT(count, 500);
  EXPECT_EQ(reader.damaged_bytes(), 0u);
  EXPECT_EQ(reader.size(), log.state().bytes);
}

TEST(Log, AVanishedFolderIsNoticedAtTheNextFlush) {
  const ScratchFolder folder;
  SessionLog log(folder / "a.lcmlog", 0);
  log.Write("A", 0, Payload(0));
  log.Flush();
  EXPECT_EQ(log.state().failure, LogFailure::kNone);
  std::filesystem::remove_all(folder.path());
  log.Write("A", 0, Payload(1));
  log.Flush();
  EXPECT_EQ(log.state().failure, LogFailure::kVanished);
  EXPECT_EQ(log.state().dropped, 1u);
}

/// The messages received on every channel.
struct Counter {
  int count = 0;
  int sound = 0;
};

// A plain function: GCC 12's undefined-behaviour sanitizer misjudges LCM's calls of members.
void Count(const lcm::ReceiveBuffer* message, const std::string& channel, Counter* counter) {
  const int i = counter->count++;
  const auto* data = static_cast<const std::uint8_t*>(message->data);
  counter->sound += channel == Channel(i) &&
                    std::vector<std::uint8_t>(data, data + message->data_size) == Payload(i);
}

TEST(Log, LcmLogplayerPlaysEveryEvent) {
  if (!InsideNetworkNamespace()) {
    if (std::system("command -v lcm-logplayer > /dev/null") != 0) {
      GTEST_SKIP() << "lcm-logplayer (package liblcm-bin) is not installed";
    }
    const std::string enter = NetworkNamespaceCommand();
    if (enter.empty()) GTEST_SKIP() << "network namespaces are refused here";
    EXPECT_EQ(RunInNetworkNamespace(enter, "Log.LcmLogplayerPlaysEveryEvent"), 0);
    return;
  }
  constexpr int kEvents = 1000;  // over 0.1 s
  const ScratchFolder folder;
  WriteLog(folder / "a.lcmlog", kEvents);
  lcm::LCM receiver("udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2000000");
  ASSERT_TRUE(receiver.good());
  Counter counter;
  receiver.subscribeFunction("HPDM_.*", Count, &counter)->setQueueCapacity(0);
  int status = -1;
  std::jthread player([&] {
    status = std::system(("lcm-logplayer " + (folder / "a.lcmlog") + " > /dev/null 2>&1").c_str());
  });
  while (counter.count < kEvents && receiver.handleTimeout(2000) > 0) {
  }
  player.join();
  EXPECT_EQ(status, 0);
  EXPECT_EQ(counter.count, kEvents);
  EXPECT_EQ(counter.sound, kEvents);
}

}  // namespace
}  // namespace hpdm
