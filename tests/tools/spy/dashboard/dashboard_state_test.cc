#include "tools/spy/dashboard/dashboard_state.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>

#include "engine/threads/histogram.h"
#include "tests/support/made_session.h"
#include "tests/support/recorded_session.h"
#include "tests/support/scratch_folder.h"
#include "tools/shared/base64.h"

namespace hpdm {
namespace {

using nlohmann::json;

constexpr char kSceneText[] = HPDM_SOURCE_DIR "/scenes/two_hands.toml";

template <typename Message>
LogEvent EventOf(const char* channel, const Message& message) {
  LogEvent event;
  event.channel = channel;
  EncodeMessage(message, &event.data);
  return event;
}

force_t Tick(std::int64_t tick, double newton, double depth = 0) {
  force_t force{};
  force.tool_count = 1;
  force.sequence = force.tick = tick;
  force.time_ns = tick * 1'000'000;
  force.tools.resize(1);
  force.tools[0].force[1] = newton;
  force.tools[0].depth = depth;
  force.tools[0].organ = -1;
  return force;
}

json Updated(DashboardState* state, DashboardState::Seen* seen) {
  return json::parse("{" + state->Update(0, seen) + "}");
}

std::vector<LogEvent> SessionEvents() {
  const ScratchFolder folder;
  Record({.scene = kSceneText, .log = folder / "s.lcmlog", .ticks = 1200, .hand_lead_ms = 900});
  LogReader reader(folder / "s.lcmlog");
  std::vector<LogEvent> events;
  for (LogEvent event; reader.Next(&event);) events.push_back(event);
  return events;
}

const std::vector<LogEvent>& Session() {
  static const std::vector<LogEvent> events = SessionEvents();
  return events;
}

TEST(Base64, EncodesTheExamplesOfRfc4648) {
  const auto of = [](const std::string& text) {
    return Base64(std::as_bytes(std::span(text.data(), text.size())));
  };
  EXPECT_EQ(of(""), "");
  EXPECT_EQ(of("f"), "Zg==");
  EXPECT_EQ(of("fo"), "Zm8=");
  EXPECT_EQ(of("foobar"), "Zm9vYmFy");
}

// A peak of a single tick at a random place is in the row of its 1/30 s.
TEST(DashboardState, LosesNoPeak) {
  DashboardState state;
  DashboardState::Seen seen;
  std::mt19937 random(1);
  double largest = 0;
  json rows = json::array();
  for (std::int64_t tick = 0; tick < 3000; ++tick) {
    const double newton =
        random() % 97 == 0 ? 1 + 1e-3 * static_cast<double>(random() % 5000) : 0.1;
    largest = std::max(largest, newton);
    state.Take(EventOf(kForceChannel, Tick(tick, newton, newton / 1000)));
    if (tick % 40 == 0) {
      for (const json& row : Updated(&state, &seen).value("rows", json::array())) {
        rows.push_back(row);
      }
    }
  }
  state.Finish();
  const json last = Updated(&state, &seen);
  for (const json& row : last.at("rows")) rows.push_back(row);
  ASSERT_EQ(rows.size(), 90u);  // 3 s of 1/30 s each
  double shown = 0, deepest = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i][0], i);
    shown = std::max(shown, rows[i][1].get<double>());
    deepest = std::max(deepest, rows[i][2].get<double>());
  }
  EXPECT_FLOAT_EQ(static_cast<float>(shown), static_cast<float>(largest));  // rows are floats
  EXPECT_FLOAT_EQ(static_cast<float>(deepest), static_cast<float>(largest / 1000));
  EXPECT_EQ(last["tools"]["tools"][0]["peak_force"], largest);
}

TEST(DashboardState, SendsEachViewerWhatItHasNotSeen) {
  DashboardState state;
  DashboardState::Seen first, second;
  for (const LogEvent& event : Session()) state.Take(event);
  state.Finish();
  const json all = Updated(&state, &first);
  for (const char* member : {"reset", "sinking", "instruments", "meshes", "organs", "rows", "tools",
                             "health", "events"}) {
    EXPECT_TRUE(all.contains(member)) << member;
  }
  EXPECT_EQ(all["instruments"], json({"probe", "grasper"}));
  EXPECT_TRUE(all["organs"][0]["fits"].get<bool>());
  EXPECT_EQ(state.Update(0, &first), "");
  EXPECT_EQ(Updated(&state, &second), all);
}

TEST(DashboardState, SumsLatenciesAsAHistogramOfAllDoes) {
  DashboardState state;
  DashboardState::Seen seen;
  Histogram all;
  std::mt19937 random(2);
  for (int second = 0; second < 3; ++second) {
    Histogram interval;
    for (int i = 0; i < 1000; ++i) {
      interval.Add(static_cast<std::int64_t>(std::exp(std::log(1e3) + 1e-3 * (random() % 7000))));
    }
    all.Merge(interval);
    stats_t stats{};
    stats.latencies[stats_t::HAPTIC_WAKE_UP].max_ns = interval.max();
    interval.ForEachBin([&stats](std::int64_t upper, std::uint64_t count) {
      bin_t bin{};
      bin.distribution = stats_t::HAPTIC_WAKE_UP;
      bin.upper_ns = upper;
      bin.count = static_cast<std::int32_t>(count);
      stats.bins.push_back(bin);
    });
    stats.bin_count = static_cast<std::int32_t>(stats.bins.size());
    state.Take(EventOf(kStatsChannel, stats));
  }
  const json update = Updated(&state, &seen);
  const json& latency = update["health"]["latencies"][0];
  EXPECT_EQ(latency["name"], "haptic.wake_up");
  EXPECT_EQ(latency["count"], all.count());
  EXPECT_EQ(latency["p50"], all.Percentile(0.5));
  EXPECT_EQ(latency["p99"], all.Percentile(0.99));
  EXPECT_EQ(latency["max"], all.max());
  std::uint64_t binned = 0;
  for (const json& bin : latency["bins"]) binned += bin[1].get<std::uint64_t>();
  EXPECT_EQ(binned, all.count());
}

TEST(DashboardState, ResetsForAnotherSession) {
  DashboardState state;
  DashboardState::Seen seen;
  for (const LogEvent& event : Session()) state.Take(event);
  const json before = Updated(&state, &seen);
  event_t start{};
  start.name = "session.start";
  start.text = "instruments: hook";
  state.Take(EventOf(kEventChannel, start));
  const json after = Updated(&state, &seen);
  EXPECT_EQ(after["reset"]["organs"], json::array());
  EXPECT_EQ(after["instruments"], json({"hook"}));
  EXPECT_EQ(state.MeshJson(0), "");
  // A repeated mesh is new to a viewer that dropped it.
  for (const LogEvent& event : Session()) {
    if (event.channel == kMeshChannel) state.Take(event);
  }
  EXPECT_NE(Updated(&state, &seen)["meshes"][0]["version"], before["meshes"][0]["version"]);
}

TEST(DashboardState, KeepsMeshesAndNamesOverASeek) {
  DashboardState state;
  DashboardState::Seen seen;
  for (const LogEvent& event : Session()) state.Take(event);
  Updated(&state, &seen);
  state.Interrupt();
  for (const LogEvent& event : Session()) state.Recall(event);  // the same meshes again
  const json after = Updated(&state, &seen);
  EXPECT_EQ(after["reset"]["organs"], json::array({0}));
  EXPECT_FALSE(after.contains("meshes"));
  EXPECT_FALSE(after.contains("rows"));
  EXPECT_EQ(after["events"][0]["name"], "session.start");
  EXPECT_NE(state.MeshJson(0), "");
}

// A viewer that starts late in a log needs meshes and names from its start.
TEST(DashboardState, TakesMeshesAndNamesOfBefore) {
  DashboardState state;
  DashboardState::Seen seen;
  for (const LogEvent& event : Session()) state.Recall(event);
  const json update = Updated(&state, &seen);
  EXPECT_EQ(update["meshes"][0]["name"], "liver");
  EXPECT_EQ(update["instruments"], json({"probe", "grasper"}));
  EXPECT_EQ(state.messages(), 0u);
}

// One damaged time wipes nothing, be it far before or after all others.
TEST(DashboardState, KeepsWhatIsShownOverAStrayTick) {
  for (const std::int64_t stray : {std::numeric_limits<std::int64_t>::max(), std::int64_t{0}}) {
    DashboardState state;
    DashboardState::Seen seen;
    for (std::int64_t tick = 5000; tick < 6000; ++tick) {
      state.Take(EventOf(kForceChannel, Tick(tick, 1)));
      if (tick != 5500) continue;
      Updated(&state, &seen);
      force_t damaged = Tick(tick, 9);
      damaged.time_ns = stray;
      state.Take(EventOf(kForceChannel, damaged));
    }
    const json update = Updated(&state, &seen);
    EXPECT_FALSE(update.contains("reset")) << stray;
    EXPECT_EQ(update["tools"]["tools"][0]["peak_force"], 1) << stray;
    EXPECT_FALSE(state.two_sessions());
  }
}

TEST(DashboardState, ContinuesAfterAGapAndLosesNoPeakThere) {
  DashboardState state;
  DashboardState::Seen seen;
  state.Take(EventOf(kForceChannel, Tick(0, 1)));
  state.Take(EventOf(kForceChannel, Tick(9000, 3)));
  state.Take(EventOf(kForceChannel, Tick(9001, 1)));
  const json update = Updated(&state, &seen);
  EXPECT_EQ(update["tools"]["time"], 9.001);
  EXPECT_EQ(update["tools"]["tools"][0]["peak_force"], 3);
}

TEST(DashboardState, FollowsAClockThatRestartedWithoutNotice) {
  DashboardState state;
  DashboardState::Seen seen;
  for (std::int64_t tick = 5000; tick < 6000; ++tick) {
    state.Take(EventOf(kForceChannel, Tick(tick, 9)));
  }
  for (std::int64_t tick = 0; tick < 200; ++tick) {
    state.Take(EventOf(kForceChannel, Tick(tick, 1)));
  }
  const json update = Updated(&state, &seen);
  EXPECT_EQ(update["tools"]["tools"][0]["peak_force"], 1);
  EXPECT_EQ(update["tools"]["time"], 0.199);
  EXPECT_FALSE(state.two_sessions());
}

TEST(DashboardState, ReportsTwoSessionsAtOnce) {
  DashboardState state;
  DashboardState::Seen seen;
  Updated(&state, &seen);
  std::int64_t tick = 0;
  for (; tick < 1000; ++tick) {
    state.Take(EventOf(kForceChannel, Tick(50'000 + tick, 1)));
    state.Take(EventOf(kForceChannel, Tick(tick, 9)));
  }
  const json update = Updated(&state, &seen);
  EXPECT_TRUE(state.two_sessions());
  EXPECT_FALSE(update.contains("reset")) << "one of them is followed";
  EXPECT_EQ(update["tools"]["tools"][0]["peak_force"], 1);
  for (const std::int64_t end = tick + 5000; tick < end; ++tick) {
    state.Take(EventOf(kForceChannel, Tick(50'000 + tick, 1)));
  }
  EXPECT_FALSE(state.two_sessions()) << "the other has ended";
}

TEST(DashboardState, SumsDamagedCountsWithinTheirRange) {
  constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max();
  DashboardState state;
  DashboardState::Seen seen;
  stats_t stats{};
  stats.haptic.missed = stats.skipped_stalled = stats.stolen_ns = stats.interval_ns = kMax;
  state.Take(EventOf(kStatsChannel, stats));
  state.Take(EventOf(kStatsChannel, stats));
  EXPECT_EQ(Updated(&state, &seen)["health"]["haptic"]["missed"], kMax);
}

std::vector<float> Floats(const std::string& base64) {
  const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<std::uint8_t> bytes;
  unsigned bits = 0;
  int count = 0;
  for (const char c : base64) {
    if (c == '=') break;
    bits = bits << 6 | static_cast<unsigned>(letters.find(c));
    if ((count += 6) < 8) continue;
    bytes.push_back(static_cast<std::uint8_t>(bits >> (count -= 8)));
  }
  std::vector<float> values(bytes.size() / sizeof(float));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(float));
  return values;
}

bool AllFinite(const std::vector<float>& values) {
  return std::all_of(values.begin(), values.end(), [](float x) { return std::isfinite(x); });
}

// Values that the page draws and charts; JSON writes null for a number that is not finite.
void ExpectFinite(const json& update) {
  for (const json& row : update.value("rows", json::array())) {
    for (const json& value : row) EXPECT_TRUE(value.is_number());
  }
  for (const json& shape : update.value("organs", json::array())) {
    for (const char* blob : {"displacements", "local_displacements"}) {
      EXPECT_TRUE(AllFinite(Floats(shape.value(blob, ""))));
    }
    for (const json& value : shape.value("offset", json::array())) EXPECT_TRUE(value.is_number());
  }
  if (!update.contains("tools")) return;
  for (const json& tool : update["tools"]["tools"]) {
    EXPECT_TRUE(tool["peak_force"].is_number() && tool["peak_depth"].is_number());
  }
}

// Flips bytes of a real session, swaps channels and cuts messages. It never crashes, every update
// is valid JSON, and the drawn values stay finite.
TEST(DashboardState, SurvivesAnyBytes) {
  std::mt19937 random(3);
  for (int round = 0; round < 20; ++round) {
    DashboardState state;
    DashboardState::Seen seen;
    for (LogEvent event : Session()) {
      if (event.channel == kToolChannel || (event.channel == kForceChannel && random() % 8 != 0)) {
        continue;
      }
      if (random() % 2 == 0) {
        for (unsigned i = 0; i < 1 + random() % 8; ++i) {
          event.data[random() % std::min<std::size_t>(event.data.size(), 1 + random() % 5000)] =
              static_cast<std::uint8_t>(random());
        }
      }
      if (random() % 10 == 0) event.data.resize(random() % event.data.size());
      if (random() % 10 == 0) event.channel = Session()[random() % Session().size()].channel;
      state.Take(event);
      if (random() % 20 == 0) {
        json update;
        ASSERT_NO_THROW(update = Updated(&state, &seen));
        ExpectFinite(update);
      }
    }
    if (const std::string mesh = state.MeshJson(0); !mesh.empty()) {
      EXPECT_TRUE(AllFinite(Floats(json::parse(mesh)["vertices"])));
    }
  }
}

// Each of these would grow without a bound: rows, events, parts of a mesh that never becomes
// complete.
TEST(DashboardState, IsBounded) {
  DashboardState state;
  DashboardState::Seen seen;
  for (std::int64_t tick = 0; tick < 200'000; tick += 10) {
    state.Take(EventOf(kForceChannel, Tick(tick, 1)));
  }
  mesh_t part{};
  part.part_count = 1'000'000;
  part.total_vertices = 1'000'000;
  part.vertices.resize(9'000);
  part.vertex_value_count = 9'000;
  part.name = "organ";
  MeshParts parts;
  for (int i = 0; i < 3000; ++i) {  // 108 MB, which is above what may wait
    part.part = i;
    state.Take(EventOf(kMeshChannel, part));
    parts.Take(mesh_t(part));
    ASSERT_LE(parts.bytes(), MeshParts::kMaxWaitingBytes);
  }
  EXPECT_EQ(parts.error(), "its mesh is too large to show");
  event_t event{};
  event.name = "name";
  event.text = std::string(100'000, '\xff');  // no UTF-8
  for (int i = 0; i < 1000; ++i) state.Take(EventOf(kEventChannel, event));
  const json update = Updated(&state, &seen);
  EXPECT_EQ(update["rows"].size(), ForceTrace::kMaxRows);
  EXPECT_EQ(update["events"].size(), DashboardState::kMaxEvents);
  EXPECT_EQ(update["mesh_errors"], json({{0, "its mesh is too large to show"}}));
  EXPECT_LT(update.dump().size(), 1'000'000u);
}

// The telemetry's messages show what it judged.
TEST(DashboardState, ShowsTheExerciseAsTheSessionJudgedIt) {
  ExerciseOptions exercise;
  exercise.name = "touch";
  exercise.time_limit = 10;
  exercise.target_time = 5;
  exercise.steps = {
      {.name = "press", .instruction = "Press the gallbladder", .touches = ExerciseContact{1, {}}},
      {.name = "free", .frees = {0}, .freed_area = 1}};
  exercise.errors = {{.name = "too strong", .limit = 3, .points = 7}};
  MadeSession session({"probe"}, {}, exercise);
  const auto press = [&](double force, int steps) {
    for (int step = 0; step < steps; ++step) {
      session.Press(33, force, force > 0 ? 1 : -1);
      session.PressStep(force, force > 0 ? 1 : -1);
    }
  };
  press(0, 30);
  press(4, 2);
  const ExerciseResult live = session.telemetry().Summary().exercise.value();
  session.Finish();
  DashboardState state;
  DashboardState::Seen seen;
  LogReader reader(session.log());
  int messages = 0;
  json first;
  for (LogEvent event; reader.Next(&event);) {
    state.Take(event);
    if (event.channel != kExerciseChannel) continue;
    if (++messages == 1) first = Updated(&state, &seen)["exercise"];
  }
  EXPECT_EQ(first["step"], 0);
  EXPECT_EQ(first["instruction"], "Press the gallbladder");
  EXPECT_EQ(first["last_error"], "");
  const json shown = Updated(&state, &seen)["exercise"];
  EXPECT_EQ(shown["name"], "touch");
  EXPECT_EQ(shown["step"], live.step_times.size());
  EXPECT_EQ(shown["steps"], 2);
  EXPECT_EQ(shown["instruction"], "free") << "a step without an instruction has its name";
  EXPECT_EQ(shown["score"], live.score);
  EXPECT_EQ(shown["errors"], live.errors.size());
  EXPECT_EQ(shown["last_error"], "too strong");
  EXPECT_EQ(shown["error_time"], live.errors.back().time);
  EXPECT_EQ(shown["ended"], false);
  // 31 steps of 33 ms without an event: one message in 0.132 s, the fourth step after the last.
  EXPECT_GE(messages, 8);
  EXPECT_LE(messages, 12);
  EXPECT_FALSE(Updated(&state, &seen).contains("exercise")) << "nothing new";
  state.Interrupt();
  EXPECT_TRUE(Updated(&state, &seen)["exercise"].is_null());
}

}  // namespace
}  // namespace hpdm
