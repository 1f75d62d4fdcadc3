// Runs every reader of logs on a real log that was cut or damaged. None may crash, hang, reserve
// more than the file can hold or report something false. Other tests choose their damage (log_test,
// log_health_test, codec_test); this one takes every prefix and random bytes.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <random>

#include "engine/base/error.h"
#include "lcmtypes/analysis/channel_table.h"
#include "lcmtypes/analysis/log_health.h"
#include "lcmtypes/analysis/logged_session.h"
#include "lcmtypes/analysis/session_invariants.h"
#include "lcmtypes/log/log_player.h"
#include "tests/support/counted_allocations.h"
#include "tests/support/recorded_session.h"
#include "tests/support/scratch_folder.h"
#include "tools/log/log_export.h"
#include "tools/log/mcap_export.h"
#include "tools/report/metrics/session_metrics.h"
#include "tools/spy/dashboard/dashboard_state.h"

// Sanitizers' own allocators refuse such an allocation.
#if defined(__SANITIZE_ADDRESS__)
extern "C" const char* __asan_default_options() { return "max_allocation_size_mb=64"; }
#endif

namespace hpdm {
namespace {

namespace fs = std::filesystem;

// HPDM_TEST_THOROUGH=1: every prefix and 10,000 flips, minutes. Else a share of them, seconds.
bool Thorough() { return std::getenv("HPDM_TEST_THOROUGH") != nullptr; }

// Largest allocation of one call: the reader's window of 1 MiB and a little more, whatever a
// damaged length claims.
constexpr std::size_t kMaxAllocation = std::size_t{3} << 20;

const SessionLimits kLimits = {.tools = {{8.9, 2}, {8.9, 2}}, .settles = {0.0}};

// A session of two instruments with every channel that a session writes.
constexpr char kDamagedScene[] = R"(
[timing]
deformation_hz = 200
[[organ]]
name = "liver"
mesh = "liver.obj"
  [organ.lattice]
  cells = 2
  local_functions = 8
  [organ.energy]
  type = "strain"
[[instrument]]
name = "probe"
trocar = [0.05, -0.12, 0.16]
[[instrument]]
name = "grasper"
type = "grasper"
trocar = [-0.06, -0.12, 0.15]
)";

// The readers' findings of one file.
struct Findings {
  std::uint64_t bytes = 0;
  std::uint64_t events = 0;
  std::uint64_t ticks = 0;
  std::uint64_t messages = 0;  // that a FromMessage takes
};

template <typename Message, typename... Out>
bool Takes(const LogEvent& event, Out*... out) {
  Message message;
  return DecodeMessage(event.data, &message) && FromMessage(message, out...);
}

bool Taken(const LogEvent& event) {
  HapticSample sample;
  StepSample step;
  OrganSnapshot shape;
  DeviceSample reading;
  std::int64_t visible = 0;
  int instrument = 0;
  if (event.channel == kToolChannel) return Takes<tool_t>(event, &sample);
  if (event.channel == kForceChannel) return Takes<force_t>(event, &sample);
  if (event.channel == kContactChannel) return Takes<contact_t>(event, &step, &visible);
  if (event.channel == kOrganChannel) return Takes<organ_t>(event, &shape);
  if (event.channel == kDeviceChannel) return Takes<device_t>(event, &reading, &instrument);
  return false;
}

class DamagedLog : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<ScratchFolder>();
    fs::copy_file(fs::path(HPDM_SOURCE_DIR) / "scenes/meshes/liver_274.obj",
                  *folder_ / "liver.obj");
    std::ofstream(*folder_ / "scene.toml") << kDamagedScene;
    // The hands are at the tissue when the record begins.
    Record({.scene = *folder_ / "scene.toml",
            .log = *folder_ / "whole.lcmlog",
            .ticks = 60,
            .hand_lead_ms = 1200});
    std::ifstream file(*folder_ / "whole.lcmlog", std::ios::binary);
    whole_.assign(std::istreambuf_iterator<char>(file), {});
  }
  static void TearDownTestSuite() { folder_.reset(); }

  void SetUp() override { ForgetLargestAllocation(); }

  // Runs every reader over `log`, and holds them against each other.
  Findings Read(const std::string& log, bool with_tables) {
    Findings found;
    found.bytes = fs::file_size(log);
    std::map<int, std::vector<mesh_t>> meshes;
    LogReader reader(log);
    for (LogEvent event; reader.Next(&event);) {
      ++found.events;
      found.messages += Taken(event);
      mesh_t part;
      if (event.channel == kMeshChannel && DecodeMessage(event.data, &part)) {
        meshes[part.organ].push_back(part);
      }
    }
    EXPECT_LE(reader.damaged_bytes(), found.bytes);
    EXPECT_LE(reader.intact_end(), found.bytes);
    for (const auto& [organ, parts] : meshes) {
      OrganDescription description;
      std::string error;
      const bool whole = JoinMesh(parts, &description, &error);
      EXPECT_EQ(whole, error.empty()) << error;
    }

    const LogHealth health = CheckLog(log, MessageSchemas::Hpdm());
    EXPECT_EQ(health.events, found.events);
    EXPECT_EQ(health.damaged_bytes + health.torn_bytes, reader.damaged_bytes());
    const auto tools =
        std::find_if(health.channels.begin(), health.channels.end(),
                     [](const ChannelFacts& c) { return c.channel == kToolChannel; });

    TickReader ticks(log);
    for (LoggedTick tick; ticks.Next(&tick);) ++found.ticks;
    EXPECT_LE(found.ticks, tools == health.channels.end() ? 0 : tools->messages);
    try {
      const LoggedSession session(log);
      EXPECT_LE(session.steps().size(), found.events);
      EXPECT_EQ(session.damaged_bytes(), reader.damaged_bytes());
    } catch (const InputError&) {  // it reports that the file has no session
    }
    for (const Invariant& invariant : CheckInvariants(log, kLimits, 100'000'000)) {
      EXPECT_LE(invariant.broken, invariant.checked) << invariant.name;
      if (invariant.name != "ticks") continue;
      EXPECT_EQ(invariant.checked, found.ticks);
    }
    ReadAsTrainersDo(log, found);
    if (with_tables) ReadTables(log, health);
    return found;
  }

  // The readers behind the spy and the report.
  void ReadAsTrainersDo(const std::string& log, const Findings& found) {
    LogPlayer player(log);
    EXPECT_EQ(player.events(), found.events);
    player.SetSpeed(LogPlayer::kUnlimited);
    ChannelTable table(MessageSchemas::Hpdm());
    DashboardState dashboard;
    for (LogEvent event; player.Next(&event, {});) {
      table.Add(event);
      dashboard.Take(event);
    }
    dashboard.Finish();
    EXPECT_TRUE(player.ended());
    EXPECT_EQ(table.messages(), found.events);
    EXPECT_GE(player.length_us(), 0);
    // A browser gets valid JSON, whatever was in the file.
    DashboardState::Seen seen;
    const std::string update = dashboard.Update(player.position_us(), &seen);
    EXPECT_TRUE(nlohmann::json::accept("{" + update + "}")) << update;
    const std::string mesh = dashboard.MeshJson(0);
    EXPECT_TRUE(mesh.empty() || nlohmann::json::accept(mesh)) << mesh;
    for (const ChannelRow& row : table.Rows(player.position_us())) {
      EXPECT_TRUE(std::isfinite(row.flow.rate_hz) && row.flow.rate_hz >= 0);
    }
    try {
      const SessionReport report = ReadSession(log).report;
      EXPECT_LE(report.ticks, found.ticks);  // some contain values that no session writes
      EXPECT_EQ(report.health.events, found.events);
      EXPECT_TRUE(std::isfinite(report.duration) && report.duration >= 0);
    } catch (const InputError&) {  // it holds no tick
    }
  }

  // The readers that write files.
  void ReadTables(const std::string& log, const LogHealth& health) {
    const std::string mended = *folder_ / "mended.lcmlog";
    fs::remove(mended);
    EXPECT_EQ(RepairLog(log, mended), health.events);
    EXPECT_EQ(CheckLog(mended, MessageSchemas::Hpdm()).damaged_bytes, 0u);
    const fs::path tables = folder_->path() / "csv";
    std::uint64_t written = 0;
    for (const ExportedChannel& table : ExportCsv(log, tables, {}, MessageSchemas::Hpdm())) {
      written += table.messages;
    }
    EXPECT_LE(written, health.events);
    fs::remove_all(tables);
    std::uint64_t in_mcap = 0;
    for (const ExportedChannel& channel :
         ExportMcap(log, *folder_ / "log.mcap", {}, MessageSchemas::Hpdm())) {
      in_mcap += channel.messages;
    }
    // Both contain every readable message; MCAP has no time stamps before 1970 or after 2554, which
    // a flip makes.
    EXPECT_LE(in_mcap, written);
  }

  std::string Write(const std::string& bytes) {
    const std::string log = *folder_ / "damaged.lcmlog";
    std::ofstream(log, std::ios::binary) << bytes;
    return log;
  }

  static inline std::unique_ptr<ScratchFolder> folder_;
  static inline std::string whole_;
};

TEST_F(DamagedLog, TheWholeHoldsEveryKindOfMessage) {
  const Findings found = Read(*folder_ / "whole.lcmlog", true);
  EXPECT_EQ(found.ticks, 60u);
  const LogHealth health = CheckLog(*folder_ / "whole.lcmlog", MessageSchemas::Hpdm());
  EXPECT_TRUE(health.Sound());
  EXPECT_EQ(health.channels.size(), 7u);  // all but HPDM_DEVICE
  EXPECT_LT(whole_.size(), 300'000u) << "every prefix of it is read";
}

TEST_F(DamagedLog, EveryPrefixIsItsWholeEvents) {
  std::vector<std::uint64_t> ends = {0};
  LogReader reader(*folder_ / "whole.lcmlog");
  for (LogEvent event; reader.Next(&event);) ends.push_back(reader.intact_end());
  const std::string log = Write(whole_);
  const int step = Thorough() ? 1 : 61;
  int count = 0;
  for (auto size = static_cast<std::int64_t>(whole_.size()); size >= 0; size -= step) {
    ASSERT_EQ(truncate(log.c_str(), size), 0);
    // Files are written for a share of them: they see the same events.
    const bool with_tables = count++ % 29 == 0;
    const Findings found = Read(log, with_tables);
    const auto whole_events =
        std::upper_bound(ends.begin(), ends.end(), static_cast<std::uint64_t>(size)) -
        ends.begin() - 1;
    ASSERT_EQ(found.events, static_cast<std::uint64_t>(whole_events)) << size;
    ASSERT_LE(LargestAllocationOfThisThread(), kMaxAllocation) << size;
  }
}

TEST_F(DamagedLog, FlippedBytesCostTheEventsAroundThem) {
  const Findings sound = Read(*folder_ / "whole.lcmlog", false);
  std::mt19937 random(11);
  const int flips = Thorough() ? 10'000 : 150;
  for (int i = 0; i < flips; ++i) {
    std::string bytes = whole_;
    // Some files are hit in several places.
    const int hits = 1 + (i % 4 == 0 ? static_cast<int>(random() % 8) : 0);
    for (int h = 0; h < hits; ++h) {
      bytes[random() % bytes.size()] ^= static_cast<char>(1 + random() % 255);
    }
    const Findings found = Read(Write(bytes), i % 7 == 0);
    // A flip hides at most the event that it hits and the one before, which nothing sound follows.
    ASSERT_GE(found.events + 2 * static_cast<std::uint64_t>(hits), sound.events) << i;
    ASSERT_LE(found.events, sound.events + static_cast<std::uint64_t>(hits)) << i;
    ASSERT_LE(LargestAllocationOfThisThread(), kMaxAllocation) << i;
  }
}

}  // namespace
}  // namespace hpdm
