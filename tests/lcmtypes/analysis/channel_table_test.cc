#include "lcmtypes/analysis/channel_table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "lcmtypes/wire/codec.h"

namespace hpdm {
namespace {

LogEvent Foreign(const std::string& channel, std::int64_t time_us, std::size_t bytes = 20) {
  LogEvent event;
  event.channel = channel;
  event.time_us = time_us;
  event.data.assign(bytes, 7);
  return event;
}

LogEvent TickEvent(std::int64_t time_us, std::int64_t sequence) {
  tool_t tool{};
  tool.sequence = sequence;
  tool.tool_count = 2;
  tool.tools.resize(2);
  LogEvent event;
  event.channel = kToolChannel;
  event.time_us = time_us;
  EncodeMessage(tool, &event.data);
  return event;
}

LogEvent Reading(std::int64_t sequence, std::int32_t instrument) {
  device_t device{};
  device.sequence = sequence;
  device.instrument = instrument;
  LogEvent event;
  event.channel = kDeviceChannel;
  EncodeMessage(device, &event.data);
  return event;
}

TEST(ChannelTable, RateJitterAndBandwidthAreThoseOfTheWindow) {
  ChannelTable table(MessageSchemas::Hpdm());
  // Intervals of 9 and 11 ms in turn: mean 10 ms, standard deviation 1 ms.
  std::int64_t t = 0;
  for (int i = 0; i <= 1000; ++i) {
    table.Add(Foreign("A", t, 50));
    t += i % 2 == 0 ? 9'000 : 11'000;
  }
  const std::int64_t last = t - 9'000;
  const ChannelFlow flow = table.Rows(last)[0].flow;
  EXPECT_NEAR(flow.rate_hz, 100,
              0.2);  // the window may hold one short interval more than long ones
  EXPECT_NEAR(flow.jitter_s, 1e-3, 1e-5);
  EXPECT_DOUBLE_EQ(flow.p99_interval_s, 11e-3);
  EXPECT_DOUBLE_EQ(flow.longest_interval_s, 11e-3);
  EXPECT_NEAR(flow.bytes_per_s, 50 * flow.rate_hz, 1e-9);
}

TEST(ChannelTable, AChannelThatFallsSilentSlowsDownWithoutAJump) {
  ChannelTable table(MessageSchemas::Hpdm());
  for (int i = 0; i < 100; ++i) table.Add(Foreign("A", i * 10'000));
  double before = table.Rows(990'000)[0].flow.rate_hz;
  EXPECT_NEAR(before, 100, 1e-9);
  for (std::int64_t now = 990'000; now < 12'000'000; now += 1'000) {
    const double rate = table.Rows(now)[0].flow.rate_hz;
    EXPECT_LE(rate, before + 1e-9);
    // Down to the last two messages of the window, each of which weighs a fifth of a hertz.
    EXPECT_GE(rate, before - 0.5);
    before = rate;
  }
  EXPECT_EQ(before, 0);
}

TEST(ChannelTable, LossIsCountedForEachInstrumentAndNotOverAnInterruption) {
  ChannelTable table(MessageSchemas::Hpdm());
  for (int i = 0; i < 20; ++i) {
    EXPECT_TRUE(table.Add(Reading(i < 7 ? i : i + 1, 0)));
    EXPECT_TRUE(table.Add(Reading(500 + i, 1)));
  }
  EXPECT_EQ(table.Rows(0)[0].facts.lost, 1u);
  EXPECT_EQ(table.Rows(0)[0].facts.not_rising, 0u);
  table.Interrupt();
  table.Add(Reading(9000, 0));
  table.Add(Reading(3, 1));
  EXPECT_EQ(table.Rows(0)[0].facts.lost, 1u);
  EXPECT_EQ(table.Rows(0)[0].facts.not_rising, 0u);
}

TEST(ChannelTable, AfterAnInterruptionTheLastMessageIsTheOneRecalled) {
  ChannelTable table(MessageSchemas::Hpdm());
  table.Add(TickEvent(10, 1));
  table.Add(TickEvent(99, 9));
  table.Interrupt();
  EXPECT_EQ(table.Find(kToolChannel).event, nullptr) << "it may be of a time to come";
  LogEvent torn = TickEvent(10, 1);
  torn.data.pop_back();
  table.Recall(torn);
  table.Recall(Foreign(kToolChannel, 10));
  EXPECT_EQ(table.Find(kToolChannel).event, nullptr);
  table.Recall(TickEvent(10, 1));
  ASSERT_NE(table.Find(kToolChannel).event, nullptr);
  EXPECT_EQ(table.Find(kToolChannel).event->time_us, 10);
  EXPECT_EQ(table.messages(), 2u) << "a message that is recalled is not counted";
}

TEST(ChannelTable, ARestartedSenderIsFollowed) {
  ChannelTable table(MessageSchemas::Hpdm());
  for (int i = 1; i <= 5000; ++i) table.Add(TickEvent(i, i));
  for (int i = 1; i <= 3000; ++i) {
    if (i != 2000) table.Add(TickEvent(i, i));
  }
  const ChannelFacts facts = table.Rows(0)[0].facts;
  EXPECT_EQ(facts.not_rising, static_cast<std::uint64_t>(ChannelCounter::kRestartRun));
  EXPECT_EQ(facts.lost, 1u);
}

TEST(ChannelTable, AMessageOfAnotherTypeOrSizeIsUnreadable) {
  ChannelTable table(MessageSchemas::Hpdm());
  EXPECT_TRUE(table.Add(TickEvent(0, 1)));
  LogEvent shorter = TickEvent(1, 2);
  shorter.data.pop_back();
  LogEvent longer = TickEvent(2, 2);
  longer.data.push_back(0);
  LogEvent other = Reading(1, 0);
  other.channel = kToolChannel;
  for (const LogEvent& event : {shorter, longer, other}) EXPECT_FALSE(table.Add(event));
  const ChannelFacts facts = table.Rows(0)[0].facts;
  EXPECT_EQ(facts.type, "hpdm.tool_t");
  EXPECT_EQ(facts.unreadable, 3u);
  // The last one that can be read stays to be shown.
  ASSERT_NE(table.Find(kToolChannel).event, nullptr);
  EXPECT_EQ(table.Find(kToolChannel).event->time_us, 0);
}

TEST(ChannelTable, NoiseBeforeTheFirstKnownMessageDoesNotHideTheType) {
  ChannelTable table(MessageSchemas::Hpdm());
  table.Add(Foreign(kToolChannel, 0));
  EXPECT_FALSE(table.Rows(0)[0].facts.known);
  EXPECT_NE(table.Find(kToolChannel).event, nullptr);
  LogEvent torn = TickEvent(1, 1);
  torn.data.pop_back();
  EXPECT_FALSE(table.Add(torn));
  EXPECT_TRUE(table.Rows(0)[0].facts.known);
  EXPECT_EQ(table.Find(kToolChannel).event, nullptr);  // the noise is not shown as of the type
  EXPECT_TRUE(table.Add(TickEvent(2, 2)));
  EXPECT_NE(table.Find(kToolChannel).event, nullptr);
  EXPECT_EQ(table.Rows(0)[0].facts.unreadable, 2u);
}

TEST(ChannelTable, AFloodOfNamesSizesAndInstrumentsFillsItButNotTheMemory) {
  ChannelTable table(MessageSchemas::Hpdm());
  for (int i = 0; i < 10'000; ++i) table.Add(Foreign("FLOOD_" + std::to_string(i), i));
  EXPECT_EQ(table.Rows(0).size(), ChannelTable::kMaxChannels);
  EXPECT_EQ(table.messages(), 10'000u);
  EXPECT_EQ(table.other_messages(), 10'000 - ChannelTable::kMaxChannels);
  EXPECT_EQ(table.other_bytes(), 20 * table.other_messages());
  EXPECT_TRUE(table.Add(TickEvent(1, 1))) << "a session is seen all the same";
  EXPECT_EQ(table.Rows(0).size(), ChannelTable::kMaxChannels + 1);

  ChannelTable large(MessageSchemas::Hpdm());
  large.Add(Foreign("A", 0, ChannelTable::kMaxKeptBytes + 1));
  EXPECT_EQ(large.Rows(0)[0].facts.messages, 1u);
  EXPECT_EQ(large.Find("A").event, nullptr);
  for (int i = 0; i < 100'000; ++i) large.Add(Reading(1, i));
  EXPECT_EQ(large.Rows(0)[1].facts.messages, 100'000u);
}

TEST(ChannelTable, TimeStampsAtBothEndsOfTheirRangeGiveFiniteFigures) {
  ChannelTable table(MessageSchemas::Hpdm());
  std::mt19937_64 random(3);
  constexpr std::int64_t kEnds[] = {std::numeric_limits<std::int64_t>::min(), 0,
                                    std::numeric_limits<std::int64_t>::max()};
  for (int i = 0; i < 1000; ++i) table.Add(Foreign("A", kEnds[random() % 3]));
  for (const std::int64_t now : kEnds) {
    const ChannelFlow flow = table.Rows(now)[0].flow;
    EXPECT_TRUE(std::isfinite(flow.rate_hz) && std::isfinite(flow.jitter_s) &&
                std::isfinite(flow.bytes_per_s) && std::isfinite(flow.longest_interval_s));
    EXPECT_GE(flow.rate_hz, 0);
  }
}

// The check skips exactly the bytes that the visit reads, for any bytes.
TEST(ChannelTable, CheckingAMessageAgreesWithDecodingIt) {
  const MessageSchemas& schemas = MessageSchemas::Hpdm();
  organ_t organ{};
  organ.sequence = 77;
  organ.value_count = 30;
  organ.displacements.resize(30);
  organ.indentation_count = 2;
  organ.indentations.resize(2);
  mesh_t mesh{};
  mesh.sequence = 78;
  mesh.name = "liver";
  mesh.kept_count = 4;
  mesh.kept.resize(4);
  std::mt19937 random(4);
  const auto compare = [&](const auto& message, std::int64_t sequence) {
    std::vector<std::uint8_t> sound;
    EncodeMessage(message, &sound);
    const LcmStruct* type = schemas.Find(sound);
    ASSERT_NE(type, nullptr);
    MessageOrder order;
    EXPECT_TRUE(schemas.Check(*type, sound, &order));
    EXPECT_EQ(order.sequence, sequence);
    for (int i = 0; i < 20'000; ++i) {
      std::vector<std::uint8_t> bytes = sound;
      if (i % 4 == 0) bytes.resize(random() % (bytes.size() + 9));
      if (!bytes.empty()) bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random());
      EXPECT_EQ(schemas.Check(*type, bytes, &order),
                schemas.Decode(*type, bytes, [](const MessageValue&) {}));
    }
  };
  compare(organ, 77);
  compare(mesh, 78);
}

}  // namespace
}  // namespace hpdm
