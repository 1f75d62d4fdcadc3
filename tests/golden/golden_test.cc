// Recorded forces that must stay as they are (tests/golden/README.md).

#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <memory>
#include <vector>

#include "lcmtypes/analysis/log_health.h"
#include "lcmtypes/log/log.h"
#include "lcmtypes/wire/codec.h"
#include "tests/support/recorded_session.h"
#include "tests/support/scratch_folder.h"
#include "tools/replay/log_replay.h"

namespace hpdm {
namespace {

struct Case {
  const char* name;
  int ticks;
  std::uint32_t busy_seed;
  ContactKind felt;  // the required contact of the last tool
};

void PrintTo(const Case& golden, std::ostream* out) { *out << golden.name; }

constexpr int kOutputEvery = 10;  // ticks
constexpr int kApproach = 40;     // ms, before the first touch

struct CloseGz {
  void operator()(gzFile file) const { gzclose(file); }
};
using GzFile = std::unique_ptr<gzFile_s, CloseGz>;

void Compress(const std::string& from, const std::string& to) {
  std::ifstream file(from, std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
  const GzFile out(gzopen(to.c_str(), "wb9"));
  ASSERT_NE(out, nullptr);
  ASSERT_EQ(gzwrite(out.get(), bytes.data(), static_cast<unsigned>(bytes.size())),
            static_cast<int>(bytes.size()));
}

void Decompress(const std::string& from, const std::string& to) {
  const GzFile in(gzopen(from.c_str(), "rb"));
  ASSERT_NE(in, nullptr) << from;
  std::ofstream out(to, std::ios::binary);
  std::vector<char> bytes(1 << 16);
  for (int n; (n = gzread(in.get(), bytes.data(), static_cast<unsigned>(bytes.size()))) > 0;) {
    out.write(bytes.data(), n);
  }
}

// When a tool of the lockstep session first touches, ms.
int FirstTouch(const std::string& scene, const std::string& log) {
  Record({.scene = scene, .log = log, .ticks = 3000});
  LoggedTick tick;
  for (TickReader ticks(log); ticks.Next(&tick);) {
    for (int t = 0; t < tick.sample.tool_count; ++t) {
      if (tick.sample.tools[t].kind != ContactKind::kNone)
        return static_cast<int>(tick.sample.tick);
    }
  }
  ADD_FAILURE() << scene << ": no tool touches";
  return 0;
}

// The log without shapes, statistics and most of the outputs.
void Thin(const std::string& from, const std::string& to) {
  LogReader reader(from);
  SessionLog thin(to, 0);
  force_t force;
  for (LogEvent event; reader.Next(&event);) {
    if (event.channel == kOrganChannel || event.channel == kStatsChannel) continue;
    if (event.channel == kForceChannel) {
      ASSERT_TRUE(DecodeMessage(event.data, &force));
      if (force.tick % kOutputEvery != 0) continue;
    }
    thin.Write(event.channel.c_str(), event.time_us * 1000, event.data);
  }
}

class Golden : public testing::TestWithParam<Case> {
 protected:
  void SetUp() override { setenv("HPDM_CACHE", (folder_ / "cache").c_str(), 1); }

  const ScratchFolder folder_;
  const std::string stem_ = std::string(HPDM_SOURCE_DIR) + "/tests/golden/" + GetParam().name;
  const std::string scene_ = stem_ + ".toml";
  const std::string packed_ = stem_ + ".lcmlog.gz";
  const std::string log_ = folder_ / "session.lcmlog";
};

TEST_P(Golden, ForcesAreStillTheRecordedOnes) {
  if (std::getenv("HPDM_WRITE_GOLDENS") != nullptr) {
    const int touch = FirstTouch(scene_, folder_ / "lockstep.lcmlog");
    Record({.scene = scene_,
            .log = folder_ / "whole.lcmlog",
            .ticks = GetParam().ticks,
            .hand_lead_ms = std::max(0, touch - kApproach),
            .busy_seed = GetParam().busy_seed});
    Thin(folder_ / "whole.lcmlog", folder_ / "thin.lcmlog");
    Compress(folder_ / "thin.lcmlog", packed_);
  }
  Decompress(packed_, log_);
  for (const ChannelFacts& channel : CheckLog(log_, MessageSchemas::Hpdm()).channels) {
    EXPECT_TRUE(channel.known) << channel.channel;
    EXPECT_EQ(channel.unreadable, 0u) << channel.channel;
  }
  const LoggedSession log(log_);
  Session session(LoadScene(scene_));
  const LogReplay replay = ReplayLog(log, 1e-9, &session);
  EXPECT_EQ(replay.ended_early, "");
  EXPECT_TRUE(log.closed());
  EXPECT_GT(replay.ticks_compared, static_cast<std::uint64_t>(GetParam().ticks / 15));
  EXPECT_EQ(replay.steps_compared, replay.steps_logged);
  if (const auto& difference = replay.comparison.first_beyond()) {
    FAIL() << (difference->in_step ? "step " : "tick ") << difference->number << ", tool "
           << difference->tool << ", " << difference->field << ": recorded " << difference->logged
           << ", now " << difference->replayed;
  }
  // The log is not trivial: every hand feels its tool, and the last tool makes its required
  // contact.
  for (int t = 0; t < replay.tool_count; ++t) EXPECT_GT(replay.forces[t].logged_peak, 0.05) << t;
  bool felt = false;
  LoggedTick tick;
  for (TickReader ticks(log_); ticks.Next(&tick);) {
    felt |=
        tick.has_output && tick.sample.tools[tick.sample.tool_count - 1].kind == GetParam().felt;
  }
  EXPECT_TRUE(felt);
}

INSTANTIATE_TEST_SUITE_P(Sessions, Golden,
                         testing::Values(Case{"press", 300, 11, ContactKind::kPress},
                                         Case{"slide", 300, 12, ContactKind::kPress},
                                         Case{"tap", 300, 13, ContactKind::kPress},
                                         Case{"grasp_pull", 500, 14, ContactKind::kGrasp},
                                         Case{"two_tools", 300, 15, ContactKind::kPress}),
                         [](const auto& golden) { return std::string(golden.param.name); });

}  // namespace
}  // namespace hpdm
