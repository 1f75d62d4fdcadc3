#include "lcmtypes/live/live_source.h"

#include <gtest/gtest.h>

#include <lcm/lcm-cpp.hpp>
#include <set>

#include "engine/base/error.h"
#include "lcmtypes/live/network.h"
#include "tests/support/network_namespace.h"

namespace hpdm {
namespace {

using std::chrono::milliseconds;

constexpr auto kPatience = milliseconds(20'000);  // a machine under load; usual are a few ms

TEST(LiveSource, EveryChannelComesWithItsArrival) {
  LiveSource source("memq://", "spy");
  const auto before = std::chrono::system_clock::now().time_since_epoch();
  const std::vector<std::uint8_t> data = {1, 2, 3};
  for (const char* channel : {"A", "B", "any name at all"}) {
    source.connection().publish(channel, data.data(), 3);
  }
  LogEvent event;
  for (const char* channel : {"A", "B", "any name at all"}) {
    ASSERT_TRUE(source.Next(&event, kPatience));
    EXPECT_EQ(event.channel, channel);
    EXPECT_EQ(event.data, data);
    EXPECT_GE(event.time_us, std::chrono::duration_cast<std::chrono::microseconds>(before).count());
  }
  EXPECT_FALSE(source.Next(&event, milliseconds(1)));
  EXPECT_FALSE(source.ended());
}

TEST(LiveSource, AReaderThatSleepsCostsBoundedMemoryAndACount) {
  LiveSource source("memq://", "spy");
  // More than wait here: 100 messages of a MB each against 64 MB.
  const std::vector<std::uint8_t> data(1 << 20);
  constexpr int kCount = 100;
  for (int i = 0; i < kCount; ++i) {
    source.connection().publish("A", data.data(), static_cast<unsigned int>(data.size()));
  }
  const auto end = std::chrono::steady_clock::now() + kPatience;
  constexpr std::uint64_t kFit = LiveSource::kMaxWaitingBytes >> 20;
  while (source.dropped() < kCount - kFit && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(milliseconds(5));
  }
  EXPECT_EQ(source.dropped(), kCount - kFit);
  LogEvent event;
  std::uint64_t got = 0;
  while (source.Next(&event, milliseconds(0))) ++got;
  EXPECT_EQ(got, kFit);
}

TEST(LiveSource, ANetworkThatIsNotThereIsRefusedWithARemedy) {
  try {
    LiveSource source("udpm://not-an-address:1", "spy");
    FAIL();
  } catch (const MachineError& error) {
    EXPECT_NE(std::string(error.what()).find("LCM_DEFAULT_URL"), std::string::npos);
  }
}

// Two programs' connections on the machine's multicast, in a network namespace of their own.
TEST(LiveSource, AFloodOnTheMulticastLosesNothing) {
  if (!InsideNetworkNamespace()) {
    const std::string enter = NetworkNamespaceCommand();
    if (enter.empty()) GTEST_SKIP() << "network namespaces are refused here";
    EXPECT_EQ(RunInNetworkNamespace(enter, "LiveSource.AFloodOnTheMulticastLosesNothing"), 0);
    return;
  }
  LiveSource source(NetworkUrl(), "spy");
  lcm::LCM sender(kLocalUrl);
  ASSERT_TRUE(sender.good());
  // Bursts of 50 messages are twice as many as a session sends in a reader's 50 ms, with a mesh
  // part in each.
  const std::vector<std::uint8_t> data(300), mesh(50'000);
  LogEvent event;
  std::uint64_t got = 0, sent = 0;
  std::set<std::string> channels;
  for (int burst = 0; burst < 100; ++burst) {
    for (int i = 0; i < 50; ++i, ++sent) {
      const bool part = i == 25;
      sender.publish(part ? "MESH" : "TOOL", part ? mesh.data() : data.data(), part ? 50'000 : 300);
    }
    while (got < sent && source.Next(&event, kPatience)) {
      ++got;
      channels.insert(event.channel);
    }
  }
  EXPECT_EQ(got, sent);
  EXPECT_EQ(channels, (std::set<std::string>{"MESH", "TOOL"}));
  EXPECT_EQ(source.dropped(), 0u);
}

}  // namespace
}  // namespace hpdm
