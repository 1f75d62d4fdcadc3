#include "tools/replay/realtime_replay.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/liver_scene.h"
#include "tests/support/recorded_session.h"
#include "tests/support/scratch_folder.h"

namespace hpdm {
namespace {

// A coarse liver and one probe.
void WriteScene(const std::string& path) {
  std::ofstream(path) << kMetricLiver +
                             "[[instrument]]\nname = \"probe\"\ntrocar = [0.05, -0.12, 0.16]\n";
}

// Runs on the machine's own clock and checks only the counts, not timing or force. Two threads run
// beside this one, and ThreadSanitizer sees every access.
TEST(RealtimeReplay, AccountsForEveryPeriodOfTheLog) {
  const ScratchFolder folder;
  const std::string scene = folder / "scene.toml", log = folder / "session.lcmlog";
  WriteScene(scene);
  Record({.scene = scene, .log = log, .ticks = 500, .busy_seed = 1});
  LoggedTick last;
  for (TickReader ticks(log); ticks.Next(&last);) {
  }
  Session session(LoadScene(scene));
  const RealtimeReplay replay = ReplayInRealTime(LoggedSession(log), &session);
  EXPECT_EQ(replay.haptic.Periods(), last.sample.tick + 1);
  EXPECT_EQ(replay.overflows, 0u);
  EXPECT_EQ(replay.session.latencies[Latency::kHapticWakeUp].count(), replay.haptic.ticks);
  EXPECT_EQ(replay.session.latencies[Latency::kHapticCompute].count(), replay.haptic.ticks);
  EXPECT_GT(replay.compared, 0u);
  EXPECT_LE(replay.compared, replay.haptic.ticks);
  EXPECT_GT(replay.deformation.ticks, 0u);
}

TEST(RealtimeReplay, APlayedMotionLeavesItsDevicesWithoutForce) {
  const ScratchFolder folder;
  WriteScene(folder / "scene.toml");
  Session session(LoadScene(folder / "scene.toml"));
  const RealtimeReplay replay = PlayInRealTime(50, &session);
  EXPECT_EQ(replay.haptic.Periods(), 50u);
  EXPECT_FALSE(session.HapticInstruments()[0].device->ForceOn());
}

}  // namespace
}  // namespace hpdm
