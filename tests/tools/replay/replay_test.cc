#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>

#include "engine/base/error.h"
#include "lcmtypes/analysis/log_health.h"
#include "lcmtypes/log/log.h"
#include "lcmtypes/wire/codec.h"
#include "tests/support/liver_scene.h"
#include "tests/support/recorded_session.h"
#include "tests/support/scratch_folder.h"
#include "tools/replay/log_replay.h"

namespace hpdm {
namespace {

class Replay : public testing::Test {
 protected:
  std::string Scene(const std::string& text, const std::string& name = "scene.toml") const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  std::string log() const { return folder_ / "session.lcmlog"; }

  // Records a session of the scene.
  void RecordOf(const std::string& scene, int ticks, std::uint32_t busy_seed = 0) {
    scene_ = Scene(scene);
    Record({.scene = scene_, .log = log(), .ticks = ticks, .busy_seed = busy_seed});
  }
  LogReplay Play(double tolerance = 0) const {
    Session session(LoadScene(scene_));
    return ReplayLog(LoggedSession(log()), tolerance, &session);
  }
  // Rewrites the log without the events that `keep` rejects; `keep` may change their bytes.
  void Rewrite(const std::function<bool(LogEvent*)>& keep) const {
    {
      LogReader reader(log());
      SessionLog changed(folder_ / "changed", 0);
      for (LogEvent event; reader.Next(&event);) {
        if (keep(&event)) changed.Write(event.channel.c_str(), event.time_us * 1000, event.data);
      }
    }
    std::filesystem::rename(folder_ / "changed", log());
  }
  static std::int64_t TickOf(const LogEvent& event) {
    tool_t tool;
    force_t force;
    if (event.channel == kToolChannel && DecodeMessage(event.data, &tool)) return tool.tick;
    if (event.channel == kForceChannel && DecodeMessage(event.data, &force)) return force.tick;
    return -1;
  }

  ScratchFolder folder_;
  std::string scene_;
};

// The log is not trivial: the tips touch, and are felt.
void ExpectContact(const LogReplay& replay) {
  for (int t = 0; t < replay.tool_count; ++t) EXPECT_GT(replay.forces[t].logged_peak, 0.01) << t;
}

TEST_F(Replay, ALockstepLogIsTheSameBitForBit) {
  RecordOf(kMetricLiver + kRearSupport + kPalpatingProbe, 900);
  const LogReplay replay = Play();
  EXPECT_FALSE(replay.comparison.first().has_value()) << replay.comparison.first()->field;
  EXPECT_EQ(replay.ended_early, "");
  EXPECT_EQ(replay.ticks_compared, 900u);
  // Counts the steps since tick 0 whose patch is due by the last tick; only those are computed.
  EXPECT_EQ(replay.steps_compared, 27u);
  EXPECT_EQ(replay.ticks_lost, 0u);
  ExpectContact(replay);
}

TEST_F(Replay, ARigidOrganIsTheSameBitForBit) {
  const std::string stomach = std::string("[[organ]]\nname = \"stomach\"\nmodel = \"rigid\"\n") +
                              "mesh = \"" + HPDM_SOURCE_DIR + "/scenes/meshes/stomach_2132.obj\"\n";
  for (const std::uint32_t seed : {0, 1}) {
    RecordOf(stomach + kPalpatingProbe + kPullingGrasper, 1200, seed);
    const LogReplay replay = Play();
    EXPECT_FALSE(replay.comparison.first().has_value()) << replay.comparison.first()->field;
    EXPECT_EQ(replay.ended_early, "");
    EXPECT_EQ(replay.ticks_compared, replay.ticks_logged);
    EXPECT_EQ(replay.steps_compared, replay.steps_logged);
    ExpectContact(replay);
  }
}

TEST_F(Replay, SkippedTicksLatePatchesAndLostDevicesAreTheSameBitForBit) {
  for (const std::uint32_t seed : {1, 2, 3}) {
    RecordOf(kMetricLiver + kRearSupport + kPalpatingProbe + kPullingGrasper, 1200, seed);
    const LoggedSession logged(log());
    std::size_t unused = 0, late = 0;
    for (const LoggedStep& step : logged.steps()) {
      unused += step.visible_tick == kNeverVisible;
      late += step.visible_tick > static_cast<std::int64_t>(step.sample.step.input_tick) + 34;
    }
    EXPECT_GT(unused, 1u);
    EXPECT_GE(late, 1u);
    const LogReplay replay = Play();
    EXPECT_FALSE(replay.comparison.first().has_value()) << replay.comparison.first()->field;
    EXPECT_EQ(replay.ended_early, "");
    EXPECT_EQ(replay.ticks_compared, replay.ticks_logged);
    EXPECT_LT(replay.ticks_logged, 1190u) << "ticks are skipped";
    EXPECT_GT(replay.ticks_logged, 1000u);
    EXPECT_EQ(replay.ticks_lost, 0u) << "skipped is not lost";
    EXPECT_EQ(replay.steps_compared, replay.steps_logged);
    ExpectContact(replay);
  }
}

// The logged pauses and exchanges, in order.
std::vector<std::string> ControlEvents(const std::string& log) {
  std::vector<std::string> names;
  LogReader reader(log);
  event_t event;
  for (LogEvent logged; reader.Next(&logged);) {
    if (logged.channel != kEventChannel || !DecodeMessage(logged.data, &event)) continue;
    if (event.name == "instrument.exchanged") names.push_back(event.text);
    if (event.name == "session.paused" || event.name == "session.resumed") {
      names.push_back(event.name);
    }
  }
  return names;
}

TEST_F(Replay, PausesAndExchangesAreTheSameBitForBit) {
  const std::string exchanges = R"(
  [[instrument.exchange]]
  name = "blunt"
  tip_radius = 0.005
  friction = 0.3
  [[instrument.exchange]]
  name = "forceps"
  type = "grasper"
)";
  scene_ = Scene(kMetricLiver + kRearSupport + kPalpatingProbe + exchanges + kPullingGrasper +
                 exchanges);
  constexpr Nanoseconds kMs = 1'000'000;
  const std::vector<TimedControl> wishes = {
      {0, {.paused = false, .instrument_index = {1, 0}}},
      {450 * kMs, {.paused = true, .instrument_index = {1, 0}}},
      {520 * kMs, {.paused = false, .instrument_index = {2, 0}}},
      {1500 * kMs, {.paused = false, .instrument_index = {0, 7}}}};  // 7: no such instrument
  for (const std::uint32_t seed : {0u, 5u}) {
    Record({.scene = scene_, .log = log(), .ticks = 2500, .busy_seed = seed, .wishes = wishes});
    const LogReplay replay = Play();
    EXPECT_FALSE(replay.comparison.first().has_value()) << replay.comparison.first()->field;
    EXPECT_EQ(replay.ended_early, "");
    EXPECT_EQ(replay.ticks_compared, replay.ticks_logged);
    ExpectContact(replay);
    EXPECT_EQ(ControlEvents(log()),
              (std::vector<std::string>{"probe: the hand holds blunt now", "session.paused",
                                        "session.resumed", "probe: the hand holds forceps now",
                                        "probe: the hand holds probe now"}));
    int paused = 0, exchanged_in_contact = 0;
    std::array<ToolSample, kMaxInstruments> last;
    LoggedTick tick;
    for (TickReader ticks(log()); ticks.Next(&tick);) {
      paused += tick.sample.paused;
      for (int t = 0; t < tick.sample.tool_count; ++t) {
        const ToolSample& tool = tick.sample.tools[t];
        exchanged_in_contact +=
            tool.instrument_index != last[t].instrument_index && last[t].kind != ContactKind::kNone;
        last[t] = tool;
      }
    }
    EXPECT_GT(paused, 50);
    EXPECT_EQ(exchanged_in_contact, 0);
  }
}

TEST_F(Replay, StopsARelaxationWhereItsClockStoppedIt) {
  RecordOf(kLiver + R"(
  [organ.lattice]
  cells = 2
  local_functions = 0
  [organ.energy]
  type = "strain"
  strain = "finite"
  newton_iterations = 5
)" + kRearSupport +
               kPalpatingProbe,
           1000, 4);
  std::size_t stopped = 0, converged = 0;
  const LoggedSession logged(log());
  for (const LoggedStep& step : logged.steps()) {
    stopped += step.sample.organs[0].out_of_time;
    converged += !step.sample.organs[0].out_of_time && step.sample.organs[0].iterations > 0;
  }
  EXPECT_GT(stopped, 3u);
  EXPECT_GT(converged, 0u);
  const LogReplay replay = Play();
  EXPECT_FALSE(replay.comparison.first().has_value()) << replay.comparison.first()->field;
  EXPECT_EQ(replay.ticks_compared, replay.ticks_logged);
  ExpectContact(replay);
}

TEST_F(Replay, FindsAChangedForceAtItsTickAndField) {
  RecordOf(kMetricLiver + kRearSupport + kPalpatingProbe, 600);
  Rewrite([](LogEvent* event) {
    force_t force;
    if (event->channel != kForceChannel || TickOf(*event) != 421) return true;
    EXPECT_TRUE(DecodeMessage(event->data, &force));
    force.tools[0].force[1] += 1e-6;
    EncodeMessage(force, &event->data);
    return true;
  });
  const LogReplay replay = Play(1e-9);
  ASSERT_TRUE(replay.comparison.first_beyond().has_value());
  const FieldDifference& difference = *replay.comparison.first_beyond();
  EXPECT_FALSE(difference.in_step);
  EXPECT_EQ(difference.number, 421u);
  EXPECT_EQ(difference.tool, 0);
  EXPECT_EQ(difference.field, "force_W");
  EXPECT_NE(difference.logged, difference.replayed);
  EXPECT_NEAR(difference.relative, 1e-6 / replay.forces[0].logged_peak, 1e-3 * difference.relative)
      << "1e-6 N survives the sum to ten digits";
  EXPECT_NEAR(replay.forces[0].peak, 1e-6, 1e-12);
  EXPECT_EQ(replay.ticks_compared, 600u) << "the replay goes on";
  // The writer's state was untouched: once there is room, the log is complete.
  EXPECT_FALSE(Play(1e-3).comparison.first_beyond().has_value());
}

TEST_F(Replay, FindsAChangedContactAtItsStep) {
  RecordOf(kMetricLiver + kRearSupport + kPalpatingProbe, 600);
  Rewrite([](LogEvent* event) {
    contact_t contact;
    if (event->channel != kContactChannel || !DecodeMessage(event->data, &contact)) return true;
    if (contact.step == 9) contact.tools[0].p_contact[2] += 1e-5;
    EncodeMessage(contact, &event->data);
    return true;
  });
  const LogReplay replay = Play(1e-9);
  ASSERT_TRUE(replay.comparison.first_beyond().has_value());
  EXPECT_TRUE(replay.comparison.first_beyond()->in_step);
  EXPECT_EQ(replay.comparison.first_beyond()->number, 9u);
  EXPECT_EQ(replay.comparison.first_beyond()->field, "contact_W");
}

TEST_F(Replay, ATornLogIsComparedAsFarAsItIsIntact) {
  RecordOf(kMetricLiver + kRearSupport + kPalpatingProbe, 600);
  const auto size = std::filesystem::file_size(log());
  for (const double share : {0.9, 0.601, 0.35}) {
    std::filesystem::resize_file(log(),
                                 static_cast<std::uintmax_t>(share * static_cast<double>(size)));
    const LoggedSession logged(log());
    EXPECT_FALSE(logged.closed());
    const LogReplay replay = Play();
    EXPECT_FALSE(replay.comparison.first().has_value()) << replay.comparison.first()->field;
    EXPECT_GT(replay.ticks_compared, 100u);
    // The record of a step in the last ticks may not have been written yet.
    EXPECT_GE(replay.ticks_compared + replay.ticks_without_output + 1, replay.ticks_logged);
    EXPECT_LT(replay.ticks_logged, 600u);
  }
}

TEST_F(Replay, EndsWhereATickIsMissing) {
  RecordOf(kMetricLiver + kRearSupport + kPalpatingProbe, 600);
  Rewrite([](LogEvent* event) { return TickOf(*event) != 300; });
  const LogReplay replay = Play();
  EXPECT_EQ(replay.ticks_lost, 1u);
  EXPECT_EQ(replay.ticks_logged, 599u);
  EXPECT_EQ(replay.ticks_compared, 300u);
  EXPECT_EQ(replay.ended_early, "1 ticks before tick 301 are not in the log");
  EXPECT_FALSE(replay.comparison.first().has_value());
}

TEST_F(Replay, EndsWhereAStepIsMissing) {
  RecordOf(kMetricLiver + kRearSupport + kPalpatingProbe, 600);
  std::int64_t visible_tick = 0;
  Rewrite([&](LogEvent* event) {
    contact_t contact;
    if (event->channel != kContactChannel || !DecodeMessage(event->data, &contact)) return true;
    if (contact.step == 8) visible_tick = contact.visible_tick;
    return contact.step != 8;
  });
  const LogReplay replay = Play();
  EXPECT_EQ(replay.steps_compared, 7u);
  EXPECT_EQ(replay.ticks_compared, static_cast<std::uint64_t>(visible_tick));
  EXPECT_NE(replay.ended_early.find("step 8 is not in the log"), std::string::npos)
      << replay.ended_early;
  EXPECT_FALSE(replay.comparison.first().has_value());
}

TEST_F(Replay, AThinnedLogIsTheSameBitForBit) {
  for (const std::uint32_t seed : {0, 1}) {
    scene_ = Scene(kMetricLiver + kRearSupport + kPalpatingProbe + kPullingGrasper);
    Recording recording = {.scene = scene_, .log = log(), .ticks = 1200, .busy_seed = seed};
    Record(recording);
    const LogReplay whole = Play();
    recording.output_interval = 50;
    Record(recording);
    const LogReplay replay = Play();
    EXPECT_FALSE(replay.comparison.first().has_value()) << replay.comparison.first()->field;
    EXPECT_EQ(replay.ended_early, "");
    EXPECT_EQ(replay.ticks_logged, whole.ticks_logged);
    EXPECT_EQ(replay.ticks_compared + replay.ticks_without_output, whole.ticks_compared);
    EXPECT_GE(replay.ticks_compared, 24u);
    EXPECT_LT(replay.ticks_compared, whole.ticks_compared / 2);
    EXPECT_EQ(replay.steps_compared, whole.steps_compared);
    for (int t = 0; t < replay.tool_count; ++t) {
      EXPECT_EQ(replay.forces[t].logged_peak, whole.forces[t].logged_peak) << "the peak is logged";
    }
    ExpectContact(replay);
    std::uint64_t lost = 0;
    LoggedTick tick;
    for (TickReader ticks(log()); ticks.Next(&tick);) lost += tick.output_lost;
    EXPECT_EQ(lost, 0u);
    EXPECT_TRUE(CheckLog(log(), MessageSchemas::Hpdm()).Sound());
  }
}

TEST_F(Replay, NamesAnAlteredOutputOfAThinnedLog) {
  scene_ = Scene(kMetricLiver + kRearSupport + kPalpatingProbe);
  Record({.scene = scene_, .log = log(), .ticks = 900, .output_interval = 50});
  std::int64_t altered = -1;
  Rewrite([&](LogEvent* event) {
    force_t force;
    if (event->channel != kForceChannel || !DecodeMessage(event->data, &force)) return true;
    if (force.tick < 700 || altered >= 0) return true;
    altered = force.tick;
    force.tools[0].force[2] = std::nextafter(force.tools[0].force[2], 1);
    EncodeMessage(force, &event->data);
    return true;
  });
  const LogReplay replay = Play();
  ASSERT_TRUE(replay.comparison.first().has_value());
  EXPECT_EQ(replay.comparison.first()->number, static_cast<std::uint64_t>(altered));
}

TEST_F(Replay, NeedsNoOutputToContinue) {
  RecordOf(kMetricLiver + kRearSupport + kPalpatingProbe, 600);
  Rewrite(
      [](LogEvent* event) { return event->channel != kForceChannel || TickOf(*event) % 10 == 0; });
  const LogReplay replay = Play();
  EXPECT_EQ(replay.ticks_compared, 60u);
  EXPECT_EQ(replay.ticks_without_output, 540u);
  EXPECT_EQ(replay.ended_early, "");
  EXPECT_FALSE(replay.comparison.first().has_value());
  ExpectContact(replay);
}

TEST_F(Replay, ALogOfAnotherSceneIsRefusedWithOneLine) {
  RecordOf(kMetricLiver + kRearSupport + kPalpatingProbe, 50);
  std::string other = kMetricLiver + kRearSupport + kPalpatingProbe;
  other.replace(other.find("liver_274"), 9, "liver_1332");
  const std::string finer =
      kMetricLiver + "  [organ.lattice]\n  cells = 5\n" + kRearSupport + kPalpatingProbe;
  for (const std::string& scene :
       {kMetricLiver + kRearSupport + kPalpatingProbe + kPullingGrasper, other, finer}) {
    scene_ = Scene(scene, "other.toml");
    try {
      Play();
      FAIL() << scene;
    } catch (const InputError& error) {
      const std::string line = error.what();
      EXPECT_NE(line.find("not a log of"), std::string::npos) << line;
      EXPECT_EQ(line.find('\n'), std::string::npos) << line;
    }
  }
}

TEST_F(Replay, AFileThatIsNotASessionIsAnInputError) {
  EXPECT_THROW(LoggedSession(folder_ / "missing.lcmlog"), InputError);
  std::ofstream(log()) << std::string(5000, 'x');
  EXPECT_THROW(LoggedSession{log()}, InputError);
}

}  // namespace
}  // namespace hpdm
