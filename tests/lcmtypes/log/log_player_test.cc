#include "lcmtypes/log/log_player.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "tests/support/scratch_folder.h"

namespace hpdm {
namespace {

using std::chrono::milliseconds;

/// Time that passes only while somebody sleeps.
struct TestClock {
  Nanoseconds now = 0;
  PlayClock Get() {
    return {[this] { return now; }, [this](Nanoseconds duration) { now += duration; }};
  }
};

class LogPlayerTest : public testing::Test {
 protected:
  static constexpr std::int64_t kEpochUs = 1'700'000'000'000'000;

  /// Events "A" every 10 ms, each with its number; `large`: 20 kB each, so that the index has many
  /// marks. Three meshes at the start and one at 5 s.
  void WriteLog(int count, bool large = false) {
    SessionLog log(log_, kEpochUs);
    std::vector<std::uint8_t> data(large ? 20'000 : 40);
    const std::vector<std::uint8_t> mesh(9);
    for (int i = 0; i < 3; ++i) log.Write(kMeshChannel, 0, mesh);
    for (int i = 0; i < count; ++i) {
      if (i == 500) log.Write(kMeshChannel, i * kPeriod, mesh);
      data[0] = static_cast<std::uint8_t>(i);
      data[1] = static_cast<std::uint8_t>(i >> 8);
      log.Write("A", i * kPeriod, data);
    }
  }

  static int NumberOf(const LogEvent& event) { return event.data[0] + 256 * event.data[1]; }

  static constexpr Nanoseconds kPeriod = 10'000'000;
  const ScratchFolder folder_;
  const std::string log_ = folder_ / "session.lcmlog";
  TestClock clock_;
};

TEST_F(LogPlayerTest, EventsComeAtTheirTimeTimesTheSpeed) {
  WriteLog(200);
  for (const double speed : {0.5, 1.0, 4.0}) {
    clock_.now = 123;
    LogPlayer player(log_, {kMeshChannel}, clock_.Get());
    EXPECT_EQ(player.length_us(), 1'990'000);
    EXPECT_EQ(player.events(), 203u);
    player.SetSpeed(speed);
    LogEvent event;
    int events = 0;
    while (!player.ended()) {
      if (!player.Next(&event, milliseconds(7))) continue;
      ++events;
      const auto expected = 1000 * static_cast<double>(event.time_us - kEpochUs) / speed;
      EXPECT_NEAR(static_cast<double>(clock_.now - 123), expected, 1);  // rounding to nanoseconds
      EXPECT_NEAR(player.position_us(), event.time_us - kEpochUs, 1);
    }
    EXPECT_EQ(events, 203);
    EXPECT_EQ(player.position_us(), player.length_us());
    EXPECT_FALSE(player.Next(&event, milliseconds(0)));
  }
}

TEST_F(LogPlayerTest, NothingComesWhilePausedAndNothingIsLostByIt) {
  WriteLog(100);
  LogPlayer player(log_, {}, clock_.Get());
  LogEvent event;
  int events = 0;
  while (clock_.now < 300'000'000) events += player.Next(&event, milliseconds(5)) ? 1 : 0;
  player.Pause(true);
  const std::int64_t position = player.position_us();
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(player.Next(&event, milliseconds(5)));
  EXPECT_EQ(player.position_us(), position);
  EXPECT_FALSE(player.ended());
  player.Pause(false);
  EXPECT_EQ(player.position_us(), position);
  while (!player.ended()) events += player.Next(&event, milliseconds(5)) ? 1 : 0;
  EXPECT_EQ(events, 103);
  // A second of the log and half a second of pause.
  EXPECT_NEAR(static_cast<double>(clock_.now), 990e6 + 500e6, 5e6);
}

TEST_F(LogPlayerTest, AnAsFastAsItCanPlayWaitsForNothing) {
  WriteLog(500);
  LogPlayer player(log_, {}, clock_.Get());
  player.SetSpeed(LogPlayer::kUnlimited);
  LogEvent event;
  int events = 0;
  while (player.Next(&event, milliseconds(100))) ++events;
  EXPECT_EQ(events, 503);
  EXPECT_EQ(clock_.now, 0);
}

TEST_F(LogPlayerTest, ASeekContinuesThereAfterTheLeadInEvenWhenPaused) {
  WriteLog(3000, true);
  LogPlayer player(log_, {}, clock_.Get());
  player.Pause(true);
  std::mt19937 random(1);
  for (int i = 0; i < 50; ++i) {
    const auto to = static_cast<std::int64_t>(random() % 29'990'001);
    player.Seek(to);
    EXPECT_EQ(player.position_us(), to);
    LogEvent event;
    int first = -1, last = -1;
    while (player.Next(&event, milliseconds(0))) {
      if (event.channel != "A") continue;
      if (first < 0) {
        first = NumberOf(event);
      } else {
        EXPECT_EQ(NumberOf(event), last + 1);
      }
      last = NumberOf(event);
    }
    EXPECT_EQ(last, to / 10'000);
    EXPECT_EQ(first, std::max<std::int64_t>(0, (to - LogPlayer::kLeadInUs + 9'999) / 10'000));
    EXPECT_EQ(player.position_us(), last == 2999 ? player.length_us() : to);
  }
  player.Seek(1'000'000'000);
  EXPECT_EQ(player.position_us(), player.length_us());
  player.Seek(-5);
  EXPECT_EQ(player.position_us(), 0);
}

TEST_F(LogPlayerTest, MeshesBeforeThePositionAreAvailableAtAnyTime) {
  WriteLog(1000, true);
  LogPlayer player(log_, {kMeshChannel}, clock_.Get());
  const auto meshes = [&player] {
    int count = 0;
    player.ForEachBefore(kMeshChannel, [&count](const LogEvent& event) {
      EXPECT_EQ(event.channel, kMeshChannel);
      ++count;
    });
    return count;
  };
  EXPECT_EQ(meshes(), 0);
  player.Seek(8'000'000);
  EXPECT_EQ(meshes(), 4);
  LogEvent event;
  ASSERT_TRUE(player.Next(&event, milliseconds(0)));
  EXPECT_EQ(NumberOf(event), 650);  // the play was not moved
  player.Seek(4'000'000);
  EXPECT_EQ(meshes(), 3);
}

TEST_F(LogPlayerTest, TheNewestBeforeASeekIsThatOfThePlace) {
  WriteLog(1000, true);
  LogPlayer player(log_, {kMeshChannel, kEventChannel}, clock_.Get());
  std::vector<std::int64_t> stamps;
  const auto look_from = [&](std::int64_t place_us) {
    stamps.clear();
    player.Seek(place_us);
    player.ForNewestBefore([&](const LogEvent& event) {
      EXPECT_EQ(event.channel, kMeshChannel);
      stamps.push_back(event.time_us - kEpochUs);
    });
  };
  look_from(8'000'000);
  EXPECT_EQ(stamps, (std::vector<std::int64_t>{5'000'000}));
  look_from(4'000'000);
  EXPECT_EQ(stamps, (std::vector<std::int64_t>{0}));
  look_from(0);
  EXPECT_TRUE(stamps.empty());
}

TEST_F(LogPlayerTest, WithoutALeadInASeekStartsAtItsPlace) {
  WriteLog(1000);
  LogPlayer player(log_, {}, clock_.Get());
  player.Seek(4'000'000, 0);
  LogEvent event;
  ASSERT_TRUE(player.Next(&event, milliseconds(0)));
  EXPECT_EQ(NumberOf(event), 400);
}

TEST_F(LogPlayerTest, AReaderThatIsTooSlowSlowsThePlay) {
  WriteLog(300);
  LogPlayer player(log_, {}, clock_.Get());
  player.SetSpeed(100);
  LogEvent event;
  int events = 0;
  while (!player.ended()) {
    events += player.Next(&event, milliseconds(5)) ? 1 : 0;
    clock_.now += 50'000'000;
    // The position never exceeds the bytes read, so a viewer's time line is correct.
    if (events > 3 && !player.ended()) {
      EXPECT_LE(player.position_us(), event.time_us - kEpochUs + 10'000);
    }
  }
  EXPECT_EQ(events, 303);
}

TEST(PlayTime, ASingleWrongStampIsMendedAndAClockSetBackCostsNoTime) {
  const auto played = [](const std::vector<std::int64_t>& stamps) {
    PlayTime time;
    std::vector<std::int64_t> result;
    for (std::size_t i = 0; i < stamps.size(); ++i) {
      result.push_back(time.Advance(stamps[i], i + 1 < stamps.size() ? &stamps[i + 1] : nullptr));
    }
    return result;
  };
  using Times = std::vector<std::int64_t>;
  EXPECT_EQ(played({10, 20, 30}), (Times{0, 10, 20}));
  EXPECT_EQ(played({0, 10, 9'000'000'000'000'000'000, 30}), (Times{0, 10, 30, 30}));
  EXPECT_EQ(played({0, 10, -9'000'000'000'000'000'000, 30}), (Times{0, 10, 10, 30}));
  EXPECT_EQ(played({10, 9'000'000'000'000'000'000, 30, 40}), (Times{0, 20, 20, 30}));
  EXPECT_EQ(played({10, -9'000'000'000'000'000'000, 30, 40}), (Times{0, 0, 20, 30}));
  // The first and the last message have no interval.
  EXPECT_EQ(played({9'000'000'000'000'000'000, 20, 30}), (Times{0, 0, 10}));
  EXPECT_EQ(played({-9'000'000'000'000'000'000, 20, 30}), (Times{0, 0, 10}));
  EXPECT_EQ(played({10, 20, 9'000'000'000'000'000'000}), (Times{0, 10, 10}));
  EXPECT_EQ(played({1000, 1010, 0, 10, 20}), (Times{0, 10, 10, 20, 30}));
  // Minutes of silence are minutes, at the start and the end too.
  constexpr std::int64_t kPause = 120'000'000;
  EXPECT_EQ(played({0, kPause, 2 * kPause, 3 * kPause}),
            (Times{0, kPause, 2 * kPause, 3 * kPause}));
  // A clock set forward, from 1970 to today, costs no time either.
  constexpr std::int64_t kToday = 1'700'000'000'000'000;
  EXPECT_EQ(played({0, 10, kToday, kToday + 10}), (Times{0, 10, 10, 20}));
}

TEST_F(LogPlayerTest, DamagedAndTornLogsPlayWhateverIsIntact) {
  WriteLog(60);
  std::ifstream file(log_, std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(file), {}};
  const auto play = [&](const std::string& bytes) {
    std::ofstream(log_, std::ios::binary) << bytes;
    LogReader reader(log_);
    LogEvent event;
    std::uint64_t intact = 0;
    while (reader.Next(&event)) ++intact;
    LogPlayer player(log_, {kMeshChannel}, clock_.Get());
    EXPECT_EQ(player.events(), intact);
    EXPECT_EQ(player.damaged_bytes(), reader.damaged_bytes());
    player.SetSpeed(LogPlayer::kUnlimited);
    std::uint64_t played = 0;
    while (player.Next(&event, milliseconds(0))) ++played;
    EXPECT_EQ(played, intact);
    player.Seek(player.length_us() / 2);
    player.ForEachBefore(kMeshChannel, [](const LogEvent&) {});
    while (player.Next(&event, milliseconds(0))) {
    }
    EXPECT_TRUE(player.ended());
    EXPECT_GE(player.length_us(), 0);
  };
  for (std::size_t size = 0; size < whole.size(); size += 7) play(whole.substr(0, size));
  std::mt19937 random(2);
  for (int i = 0; i < 300; ++i) {
    std::string flipped = whole;
    for (int k = 0; k <= i % 3; ++k) {
      flipped[random() % flipped.size()] ^= static_cast<char>(1 + random() % 255);
    }
    play(flipped);
  }
}

}  // namespace
}  // namespace hpdm
