#include "lcmtypes/telemetry/live_publisher.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <lcm/lcm-cpp.hpp>
#include <map>
#include <string>
#include <type_traits>

#include "lcmtypes/live/network.h"
#include "tests/support/network_namespace.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/telemetry_fixture.h"

namespace hpdm {
namespace {

int OpenSockets() {
  int sockets = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    std::error_code ignored;
    const std::string target = std::filesystem::read_symlink(entry, ignored).string();
    sockets += target.starts_with("socket:");
  }
  return sockets;
}

TEST(LivePublisher, OpensNoSocketAndCountsNothingUnlessLive) {
  const int before = OpenSockets();
  LivePublisher live(false, kNanosecondsPerSecond);
  live.SetMeshes({mesh_t{}});
  const std::uint8_t message[] = {1, 2, 3};
  live.Publish(kToolChannel, message);
  live.PublishMeshPart(0);
  EXPECT_EQ(OpenSockets(), before);
  EXPECT_EQ(live.messages(), 0u);
  EXPECT_EQ(live.errors(), 0u);
}

/// Messages that arrived, in the order of their sequence numbers.
struct Receiver {
  std::map<std::string, std::int64_t> last_sequence;
  std::vector<mesh_t> meshes;
};

// A plain function: GCC 12's undefined-behaviour sanitizer misjudges LCM's calls of members.
template <typename Message>
void Receive(const lcm::ReceiveBuffer* received, const std::string& channel, Receiver* receiver) {
  Message message;
  const auto* data = static_cast<const std::uint8_t*>(received->data);
  ASSERT_TRUE(DecodeMessage({data, received->data_size}, &message)) << channel;
  EXPECT_EQ(message.sequence, ++receiver->last_sequence[channel]) << channel;
  if constexpr (std::is_same_v<Message, mesh_t>) receiver->meshes.push_back(message);
}

template <typename Message>
void Subscribe(lcm::LCM* lcm, const char* channel, Receiver* receiver) {
  lcm->subscribeFunction(channel, Receive<Message>, receiver)->setQueueCapacity(0);
}

/// Subscribes to all channels of a session, in a network namespace of its own.
struct Network {
  Network() {
    Subscribe<tool_t>(&lcm, kToolChannel, &receiver);
    Subscribe<force_t>(&lcm, kForceChannel, &receiver);
    Subscribe<contact_t>(&lcm, kContactChannel, &receiver);
    Subscribe<organ_t>(&lcm, kOrganChannel, &receiver);
    Subscribe<mesh_t>(&lcm, kMeshChannel, &receiver);
    Subscribe<stats_t>(&lcm, kStatsChannel, &receiver);
    Subscribe<event_t>(&lcm, kEventChannel, &receiver);
  }
  /// Takes messages until none comes for `milliseconds`.
  void Receive(int milliseconds) {
    while (lcm.handleTimeout(milliseconds) > 0) {
    }
  }

  lcm::LCM lcm{std::string(kLocalUrl) + "&recv_buf_size=4000000"};
  Receiver receiver;
};

/// Edges and log of a telemetry loop that publishes, and a receiver of its messages.
struct LiveSession {
  LiveSession() { options.live = true; }
  /// Makes the loop, with a log of the given name.
  TelemetryLoop Telemetry(const std::string& name = "session.lcmlog") {
    return {&samples, &edges.steps, &edges.scenes, folder / name, options, TwoProbesAndALiver()};
  }
  std::int64_t LastSequence(const char* channel) { return network.receiver.last_sequence[channel]; }

  Network network;
  ScratchFolder folder;
  SpscQueue<HapticSample> samples{64};
  StepEdges edges;
  TelemetryOptions options;
};

bool CanEnterNetworkNamespace() {
  return InsideNetworkNamespace() || !NetworkNamespaceCommand().empty();
}

/// Runs the test again in a network namespace; false if this process is in one already.
bool RanInNetworkNamespace(const std::string& test) {
  if (InsideNetworkNamespace()) return false;
  EXPECT_EQ(RunInNetworkNamespace(NetworkNamespaceCommand(), "LivePublisher." + test), 0);
  return true;
}

void ExpectTheMeshThreeTimes(const std::vector<mesh_t>& parts) {
  const auto count = static_cast<std::size_t>(parts.at(0).part_count);
  ASSERT_EQ(parts.size(), 3 * count) << "at 0, 0.5 and 1 s";
  for (std::size_t repeat = 0; repeat < 3; ++repeat) {
    OrganDescription organ;
    std::string error;
    EXPECT_TRUE(JoinMesh({&parts[repeat * count], count}, &organ, &error)) << error;
  }
}

TEST(LivePublisher, SendsEveryMessageOfASessionAndRepeatsTheMesh) {
  if (!CanEnterNetworkNamespace()) GTEST_SKIP() << "network namespaces are refused here";
  if (RanInNetworkNamespace("SendsEveryMessageOfASessionAndRepeatsTheMesh")) return;
  LiveSession live;
  ASSERT_TRUE(live.network.lcm.good());
  constexpr std::uint64_t kTicks = 1100;
  live.options.mesh_repeat = kNanosecondsPerSecond / 2;
  TelemetryLoop telemetry = live.Telemetry();
  for (std::uint64_t tick = 0; tick < kTicks; ++tick) {
    if (tick % 40 == 0) live.edges.Publish(tick / 40 + 1, tick);
    live.samples.Push(Sample(tick, tick / 40 + 1, tick / 40 * 40));
    telemetry.Drain();
    live.network.Receive(0);
  }
  telemetry.Finish();
  live.network.Receive(200);
  EXPECT_EQ(telemetry.Summary().live_errors, 0u);
  EXPECT_EQ(live.LastSequence(kToolChannel), static_cast<std::int64_t>(kTicks));
  EXPECT_EQ(live.LastSequence(kForceChannel), static_cast<std::int64_t>(kTicks));
  EXPECT_EQ(live.LastSequence(kContactChannel), 28);
  EXPECT_EQ(live.LastSequence(kOrganChannel), 28);
  EXPECT_EQ(live.LastSequence(kStatsChannel), 2);
  ExpectTheMeshThreeTimes(live.network.receiver.meshes);

  // The log holds the mesh once and everything else as it was published.
  const LogContents log = ReadLog(live.folder / "session.lcmlog");
  EXPECT_EQ(3 * log.meshes.size(), live.network.receiver.meshes.size());
  EXPECT_EQ(log.ticks.size(), kTicks);
}

TEST(LivePublisher, SendsEveryOutputOfAThinnedLog) {
  if (!CanEnterNetworkNamespace()) GTEST_SKIP() << "network namespaces are refused here";
  if (RanInNetworkNamespace("SendsEveryOutputOfAThinnedLog")) return;
  LiveSession live;
  ASSERT_TRUE(live.network.lcm.good());
  live.options.output_interval = 100;
  TelemetryLoop telemetry = live.Telemetry();
  // Forces fall from tick 2000 on, so none is a new peak. One contact ends at tick 2142.
  for (std::uint64_t tick = 2000; tick < 2400; ++tick) {
    if (tick % 40 == 0) live.edges.Publish(tick / 40 - 49, tick);
    live.samples.Push(Sample(tick, 1, 2000));
    telemetry.Drain();
    live.network.Receive(0);
  }
  telemetry.Finish();
  live.network.Receive(200);
  EXPECT_EQ(live.LastSequence(kForceChannel), 400);
  EXPECT_EQ(live.LastSequence(kOrganChannel), 10);
  LogContents log = ReadLog(live.folder / "session.lcmlog");
  EXPECT_EQ(log.last_sequence[kForceChannel], 5);
  EXPECT_EQ(log.last_sequence[kOrganChannel], 4);
}

TEST(LivePublisher, LeavesTheForcesToTheLinkOfAnExternalDriver) {
  if (!CanEnterNetworkNamespace()) GTEST_SKIP() << "network namespaces are refused here";
  if (RanInNetworkNamespace("LeavesTheForcesToTheLinkOfAnExternalDriver")) return;
  LiveSession live;
  ASSERT_TRUE(live.network.lcm.good());
  live.options.forces_linked = true;
  {
    const TelemetryLoop linked = live.Telemetry("linked.lcmlog");
    for (std::uint64_t tick = 0; tick < 50; ++tick) live.samples.Push(Sample(tick, 0));
  }
  live.network.Receive(200);
  EXPECT_EQ(live.LastSequence(kToolChannel), 50);
  EXPECT_EQ(live.network.receiver.last_sequence.count(kForceChannel), 0u);
  EXPECT_EQ(ReadLog(live.folder / "linked.lcmlog").ticks.size(), 50u);
}

}  // namespace
}  // namespace hpdm
