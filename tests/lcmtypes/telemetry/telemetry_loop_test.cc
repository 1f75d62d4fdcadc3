#include "lcmtypes/telemetry/telemetry_loop.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <lcm/lcm-cpp.hpp>
#include <map>
#include <sstream>
#include <thread>

#include "engine/base/error.h"
#include "tests/support/network_namespace.h"
#include "tests/support/read_file.h"
#include "tests/support/scratch_folder.h"

namespace hpdm {
namespace {

constexpr Nanoseconds kPeriod = 1'000'000;
constexpr int kControlPoints = 20;
constexpr int kPatchDelayTicks = 34;

SessionInfo TwoProbesAndALiver() {
  SessionInfo info;
  info.instruments = {"left", "right"};
  OrganDescription& liver = info.organs.emplace_back();
  liver.name = "liver";
  liver.vertices = Points::Constant(9000, 3, 0.5);
  liver.triangles = Triangles::Zero(9000, 3);
  LatticeDescription& lattice = liver.lattice.emplace();
  for (int i = 0; i < kControlPoints; ++i) lattice.kept.push_back(i);
  return info;
}

SceneSnapshot EmptyScene() {
  SceneSnapshot scene;
  scene.organs.resize(1);
  scene.organs[0].control_displacements = Points::Zero(kControlPoints, 3);
  return scene;
}

/// `patch_tick`: the first that used the patch.
HapticSample Sample(std::uint64_t tick, std::uint64_t patch_number, std::uint64_t patch_tick = 0) {
  HapticSample sample;
  sample.tick = tick;
  sample.time_ns = static_cast<Nanoseconds>(tick) * kPeriod;
  sample.device_time_ns = sample.time_ns;
  sample.patch_number = patch_number;
  sample.patch_tick = patch_tick;
  sample.patch_age_ns = 20 * kPeriod;
  sample.tool_count = 2;
  for (int i = 0; i < 2; ++i) {
    ToolSample& tool = sample.tools[i];
    tool.joints.setConstant(std::sin(1e-3 * static_cast<double>(tick) + i));
    tool.p_tip_W = Vector3d(0.1 * i, 0.2, tool.joints[0]);
    tool.force_W = Vector3d(0, 0, i + std::max(0.0, tool.joints[0]));
    tool.kind = tool.joints[0] > 0 ? ContactKind::kPress : ContactKind::kNone;
    tool.device_valid = true;
  }
  return sample;
}

/// The two edges from the deformation loop.
struct StepEdges {
  explicit StepEdges(std::size_t capacity = 64) : steps(capacity) {}

  void Publish(std::uint64_t number, std::uint64_t tick) {
    StepSample sample;
    sample.step.number = number;
    sample.step.input_tick = tick;
    sample.step.time_ns = static_cast<Nanoseconds>(tick) * kPeriod;
    sample.tool_count = 2;
    steps.Push(sample);
    SceneSnapshot& scene = scenes.Back();
    scene.step = sample.step;
    scene.organs[0].version = number;
    scene.organs[0].control_displacements.setConstant(1e-3 * static_cast<double>(number));
    scenes.Publish();
  }

  SpscQueue<StepSample> steps;
  TripleBuffer<SceneSnapshot> scenes{EmptyScene()};
};

/// A session in the lockstep clock: step j starts at tick ceil(j 1000 / 30) and its patch is
/// visible kPatchDelayTicks later; the telemetry drains after every tick.
TelemetrySummary RunLockstep(const std::string& log_path, TelemetryOptions options, int ticks) {
  SpscQueue<HapticSample> samples(64);
  StepEdges edges;
  TelemetryLoop telemetry(&samples, &edges.steps, &edges.scenes, log_path, options,
                          TwoProbesAndALiver());
  std::uint64_t step = 0, last_patch = 0, patch_tick = 0;
  for (std::uint64_t tick = 0; tick < static_cast<std::uint64_t>(ticks); ++tick) {
    if (tick * 30 >= step * 1000) edges.Publish(++step, tick);
    // The newest step that started at least kPatchDelayTicks ago.
    const std::uint64_t patch =
        tick < kPatchDelayTicks ? 0 : (tick - kPatchDelayTicks) * 30 / 1000 + 1;
    if (patch != last_patch) patch_tick = tick;
    last_patch = patch;
    samples.Push(Sample(tick, patch, patch_tick));
    telemetry.Drain();
  }
  telemetry.Finish();
  return telemetry.Summary();
}

struct LogContents {
  std::vector<HapticSample> ticks;  // put together from HPDM_TOOL and HPDM_FORCE
  std::vector<contact_t> contacts;
  std::vector<organ_t> organs;
  std::vector<mesh_t> meshes;
  std::vector<stats_t> stats;
  std::vector<event_t> events;
  std::map<std::string, std::int64_t> last_sequence;
};

template <typename Message>
Message Decoded(const LogEvent& event, LogContents* contents) {
  Message message;
  EXPECT_TRUE(DecodeMessage(event.data, &message)) << event.channel;
  EXPECT_EQ(message.sequence, ++contents->last_sequence[event.channel]) << event.channel;
  return message;
}

LogContents ReadLog(const std::string& path) {
  LogContents contents;
  LogReader reader(path);
  std::int64_t number = 0, last_us = 0;
  for (LogEvent event; reader.Next(&event);) {
    EXPECT_EQ(event.number, number++);
    EXPECT_GE(event.time_us, last_us);
    last_us = event.time_us;
    if (event.channel == kToolChannel) {
      EXPECT_TRUE(FromMessage(Decoded<tool_t>(event, &contents), &contents.ticks.emplace_back()));
    } else if (event.channel == kForceChannel) {
      const force_t force = Decoded<force_t>(event, &contents);
      EXPECT_EQ(static_cast<std::uint64_t>(force.tick), contents.ticks.back().tick);
      EXPECT_TRUE(FromMessage(force, &contents.ticks.back()));
    } else if (event.channel == kContactChannel) {
      contents.contacts.push_back(Decoded<contact_t>(event, &contents));
    } else if (event.channel == kOrganChannel) {
      contents.organs.push_back(Decoded<organ_t>(event, &contents));
    } else if (event.channel == kMeshChannel) {
      contents.meshes.push_back(Decoded<mesh_t>(event, &contents));
    } else if (event.channel == kStatsChannel) {
      contents.stats.push_back(Decoded<stats_t>(event, &contents));
    } else if (event.channel == kEventChannel) {
      contents.events.push_back(Decoded<event_t>(event, &contents));
    } else {
      ADD_FAILURE() << "unknown channel " << event.channel;
    }
  }
  EXPECT_EQ(reader.damaged_bytes(), 0u);
  return contents;
}

TEST(TelemetryLoop, EveryTickIsInTheLogOnceInOrderAndExact) {
  const ScratchFolder folder;
  RunLockstep(folder / "session.lcmlog", {}, 2500);
  const LogContents log = ReadLog(folder / "session.lcmlog");
  ASSERT_EQ(log.ticks.size(), 2500u);
  for (std::uint64_t tick = 0; tick < 2500; ++tick) {
    const HapticSample& logged = log.ticks[tick];
    const HapticSample pushed = Sample(tick, logged.patch_number);
    ASSERT_EQ(logged.tick, tick);
    for (int i = 0; i < 2; ++i) {
      ASSERT_EQ(logged.tools[i].joints, pushed.tools[i].joints);
      ASSERT_EQ(logged.tools[i].force_W, pushed.tools[i].force_W);
    }
  }
}

TEST(TelemetryLoop, EveryStepIsInTheLogWithItsInputAndVisibleTick) {
  const ScratchFolder folder;
  RunLockstep(folder / "session.lcmlog", {}, 2000);
  const LogContents log = ReadLog(folder / "session.lcmlog");
  ASSERT_EQ(log.contacts.size(), 60u);
  ASSERT_EQ(log.organs.size(), 60u);
  for (std::size_t i = 0; i < 60; ++i) {
    const contact_t& contact = log.contacts[i];
    const auto input_tick = static_cast<std::int64_t>((1000 * i + 29) / 30);
    EXPECT_EQ(contact.step, static_cast<std::int64_t>(i) + 1);
    EXPECT_EQ(contact.input_tick, input_tick);
    const std::int64_t visible = input_tick + kPatchDelayTicks;
    EXPECT_EQ(contact.visible_tick, visible < 2000 ? visible : kNeverVisible);
    EXPECT_EQ(log.organs[i].step, contact.step);
    EXPECT_EQ(log.organs[i].value_count, 3 * kControlPoints);
    EXPECT_FLOAT_EQ(log.organs[i].displacements[0], 1e-3F * static_cast<float>(i + 1));
  }
}

TEST(TelemetryLoop, AShapeThatStaysIsSentOnceASecondAndOneThatMovesAtEveryStep) {
  const ScratchFolder folder;
  constexpr int kSteps = 120, kMoves = 90;  // of 1/30 s each
  {
    SpscQueue<HapticSample> samples(64);
    StepEdges edges;
    TelemetryLoop telemetry(&samples, &edges.steps, &edges.scenes, folder / "session.lcmlog", {},
                            TwoProbesAndALiver());
    for (int step = 0; step < kSteps; ++step) {
      SceneSnapshot& scene = edges.scenes.Back();
      scene.step.number = static_cast<std::uint64_t>(step) + 1;
      scene.step.time_ns = step * kNanosecondsPerSecond / 30;
      scene.organs[0].offset_W.x() = 1e-3 * std::max(0, step - kMoves);
      edges.scenes.Publish();
      telemetry.Drain();
    }
  }
  std::vector<std::int64_t> steps;
  for (const organ_t& organ : ReadLog(folder / "session.lcmlog").organs) {
    steps.push_back(organ.step);
  }
  std::vector<std::int64_t> expected = {1, 31, 61};
  for (int step = kMoves; step < kSteps; ++step) expected.push_back(step + 1);
  EXPECT_EQ(steps, expected);
}

TEST(TelemetryLoop, AStepThatNoTickUsedIsNeverVisible) {
  const ScratchFolder folder;
  {
    SpscQueue<HapticSample> samples(64);
    StepEdges edges;
    TelemetryLoop telemetry(&samples, &edges.steps, &edges.scenes, folder / "session.lcmlog", {},
                            SessionInfo());
    const auto publish = [&](std::uint64_t number) { edges.Publish(number, 10 * number); };
    publish(1);
    telemetry.Drain();
    publish(2);  // replaced by 3 before a tick looked
    telemetry.Drain();
    publish(3);
    telemetry.Drain();
    samples.Push(Sample(41, 3, 41));
    samples.Push(Sample(42, 3, 41));
    samples.Push(Sample(43, 4, 43));  // the tick's sample overtakes step 4's snapshot
    telemetry.Drain();
    publish(4);
    telemetry.Drain();
    publish(5);
    telemetry.Drain();
  }  // closing is what the destructor does without Finish
  const LogContents log = ReadLog(folder / "session.lcmlog");
  ASSERT_EQ(log.contacts.size(), 5u);
  const std::int64_t visible[] = {kNeverVisible, kNeverVisible, 41, 43, kNeverVisible};
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(log.contacts[i].visible_tick, visible[i]) << i;
}

// However late the telemetry comes: a disk held it up for a second of steps at 1 kHz.
TEST(TelemetryLoop, EveryStepOfALateDrainIsLoggedWithTheTickThatFirstUsedIt) {
  const ScratchFolder folder;
  {
    SpscQueue<HapticSample> samples(1024);
    StepEdges edges(1024);
    TelemetryLoop telemetry(&samples, &edges.steps, &edges.scenes, folder / "session.lcmlog", {},
                            SessionInfo());
    for (std::uint64_t n = 1; n <= 900; ++n) {
      edges.Publish(n, n);
      // Every third patch is replaced before a tick looks.
      if (n % 3 != 0) samples.Push(Sample(n + 1, n, n + 1));
    }
    telemetry.Drain();
  }
  const LogContents log = ReadLog(folder / "session.lcmlog");
  ASSERT_EQ(log.contacts.size(), 900u);
  EXPECT_EQ(log.organs.size(), 1u) << "shapes are the latest value only";
  for (std::int64_t n = 1; n <= 900; ++n) {
    EXPECT_EQ(log.contacts[n - 1].step, n);
    EXPECT_EQ(log.contacts[n - 1].visible_tick, n % 3 != 0 ? n + 1 : kNeverVisible);
  }
}

TEST(TelemetryLoop, ALostTickDoesNotMoveAPatchsFirstUse) {
  const ScratchFolder folder;
  {
    SpscQueue<HapticSample> samples(2);
    StepEdges edges(2);
    TelemetryLoop telemetry(&samples, &edges.steps, &edges.scenes, folder / "session.lcmlog", {},
                            SessionInfo());
    edges.Publish(1, 0);
    samples.Push(Sample(0, 0));
    samples.Push(Sample(1, 0));
    samples.Push(Sample(2, 1, 2));  // lost: the queue holds two
    telemetry.Drain();
    samples.Push(Sample(3, 1, 2));
    for (std::uint64_t n = 2; n <= 4; ++n) edges.Publish(n, n);  // 4 is lost
    telemetry.Finish();
    EXPECT_EQ(telemetry.Summary().queue_overflows, 1u);
    EXPECT_EQ(telemetry.Summary().step_overflows, 1u);
  }
  const LogContents log = ReadLog(folder / "session.lcmlog");
  ASSERT_EQ(log.contacts.size(), 3u);
  EXPECT_EQ(log.contacts[0].visible_tick, 2);
}

TEST(TelemetryLoop, TheLogsMeshIsTheOrgan) {
  const ScratchFolder folder;
  RunLockstep(folder / "session.lcmlog", {}, 1);
  const LogContents log = ReadLog(folder / "session.lcmlog");
  EXPECT_GT(log.meshes.size(), 1u);
  OrganDescription organ;
  std::string error;
  ASSERT_TRUE(JoinMesh(log.meshes, &organ, &error)) << error;
  EXPECT_EQ(organ.vertices.rows(), 9000);
  EXPECT_EQ(organ.lattice->kept.size(), static_cast<std::size_t>(kControlPoints));
}

TEST(TelemetryLoop, TwoLockstepSessionsAreTheSameBytes) {
  const ScratchFolder folder;
  for (const char* name : {"a", "b"}) {
    TelemetryOptions options;
    options.timeline_path = folder / (std::string(name) + ".csv");
    RunLockstep(folder / (std::string(name) + ".lcmlog"), options, 3000);
  }
  const std::string log = ReadFile(folder / "a.lcmlog");
  EXPECT_GT(log.size(), 3000u * 600u);
  EXPECT_TRUE(log == ReadFile(folder / "b.lcmlog"));
  const std::string timeline = ReadFile(folder / "a.csv");
  EXPECT_GT(timeline.size(), 300u * 20u);
  EXPECT_TRUE(timeline == ReadFile(folder / "b.csv"));
}

TEST(TelemetryLoop, StatisticsComeOnceASessionSecond) {
  const ScratchFolder folder;
  const TelemetrySummary summary = RunLockstep(folder / "session.lcmlog", {}, 2500);
  const LogContents log = ReadLog(folder / "session.lcmlog");
  ASSERT_EQ(log.stats.size(), 3u);
  const std::int64_t ticks[] = {1000, 1000, 500};
  const std::int64_t steps[] = {30, 30, 15};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(log.stats[i].haptic.cycles, ticks[i]);
    EXPECT_EQ(log.stats[i].deformation.cycles, steps[i]);
    EXPECT_EQ(log.stats[i].interval_ns, ticks[i] * kPeriod);
    EXPECT_DOUBLE_EQ(log.stats[i].haptic.rate_hz, 1000);
    EXPECT_DOUBLE_EQ(log.stats[i].deformation.rate_hz, 30);
    EXPECT_EQ(log.stats[i].latencies[stats_t::HAPTIC_WAKE_UP].max_ns, 0)
        << "nothing measured in lockstep";
  }
  EXPECT_EQ(summary.session.ticks, 2500u);
  EXPECT_EQ(summary.session.ticks_lost, 0u);
  EXPECT_EQ(summary.session.steps, 75u);
  EXPECT_EQ(summary.session.steps_lost, 0u);
  EXPECT_EQ(summary.queue_overflows, 0u);
  EXPECT_EQ(summary.log.failure, LogFailure::kNone);
  EXPECT_EQ(log.events.front().name, "session.start");
  EXPECT_EQ(log.events.front().text, "instruments: left, right");
  EXPECT_EQ(log.events.back().name, "session.end");
}

TEST(TelemetryLoop, TheTimelineHoldsEveryTenthTick) {
  const ScratchFolder folder;
  TelemetryOptions options;
  options.timeline_path = folder / "timeline.csv";
  EXPECT_EQ(RunLockstep(folder / "session.lcmlog", options, 1000).timeline_failure, "");
  std::istringstream file(ReadFile(options.timeline_path));
  std::string line;
  ASSERT_TRUE(std::getline(file, line));
  EXPECT_EQ(line,
            "t,left_force,left_fx,left_fy,left_fz,left_depth,left_x,left_y,left_z,left_contact,"
            "right_force,right_fx,right_fy,right_fz,right_depth,right_x,right_y,right_z,"
            "right_contact");
  for (std::uint64_t row = 0; row < 100; ++row) {
    ASSERT_TRUE(std::getline(file, line));
    std::vector<double> values;
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) values.push_back(std::stod(cell));
    ASSERT_EQ(values.size(), 19u);
    const HapticSample sample = Sample(10 * row, 0);
    const ToolSample& right = sample.tools[1];
    // Nine significant digits of numbers below 2.
    EXPECT_NEAR(values[0], 0.01 * static_cast<double>(row), 1e-9);
    EXPECT_NEAR(values[10], right.force_W.norm(), 1e-8);
    EXPECT_NEAR(values[13], right.force_W.z(), 1e-8);
    EXPECT_NEAR(values[17], right.p_tip_W.z(), 1e-8);
    EXPECT_EQ(values[18], right.kind == ContactKind::kNone ? 0 : 1);
  }
  EXPECT_FALSE(std::getline(file, line));
}

TEST(TelemetryLoop, AFullQueueIsCountedAndSaidOnce) {
  const ScratchFolder folder;
  SpscQueue<HapticSample> samples(16);
  StepEdges edges;
  TelemetryLoop telemetry(&samples, &edges.steps, &edges.scenes, folder / "session.lcmlog", {},
                          SessionInfo());
  for (std::uint64_t tick = 0; tick < 20; ++tick) samples.Push(Sample(tick, 0));
  telemetry.Drain();
  samples.Push(Sample(20, 0));
  telemetry.Finish();
  EXPECT_EQ(telemetry.Summary().queue_overflows, 4u);
  EXPECT_EQ(telemetry.Summary().session.ticks_lost, 4u) << "both ways of counting agree";
  const LogContents log = ReadLog(folder / "session.lcmlog");
  EXPECT_EQ(log.ticks.size(), 17u);
  EXPECT_EQ(std::count_if(log.events.begin(), log.events.end(),
                          [](const event_t& e) { return e.name == "telemetry.overflow"; }),
            1);
}

TEST(TelemetryLoop, ALogThatFailsIsReportedAndTheSessionGoesOn) {
  if (access("/dev/full", W_OK) != 0) GTEST_SKIP() << "no /dev/full here";
  const TelemetrySummary summary = RunLockstep("/dev/full", {}, 1500);
  EXPECT_EQ(summary.log.failure, LogFailure::kWrite);
  EXPECT_GT(summary.log.dropped, 3000u);
  EXPECT_EQ(summary.session.ticks, 1500u);
}

TEST(TelemetryLoop, AFolderThatDoesNotExistIsAnInputError) {
  const ScratchFolder folder;
  SpscQueue<HapticSample> samples(16);
  StepEdges edges;
  EXPECT_THROW(TelemetryLoop(&samples, &edges.steps, &edges.scenes, folder / "no/session.lcmlog",
                             {}, SessionInfo()),
               InputError);
  TelemetryOptions options;
  options.timeline_path = folder / "no/timeline.csv";
  EXPECT_THROW(TelemetryLoop(&samples, &edges.steps, &edges.scenes, folder / "session.lcmlog",
                             options, SessionInfo()),
               InputError);
}

TEST(TelemetryLoop, ADeviceThatIsLostAndComesBackIsTwoEventsAtTheirTicks) {
  const ScratchFolder folder;
  {
    SpscQueue<HapticSample> samples(1024);
    StepEdges edges;
    TelemetryLoop telemetry(&samples, &edges.steps, &edges.scenes, folder / "session.lcmlog", {},
                            TwoProbesAndALiver());
    for (std::uint64_t tick = 0; tick < 300; ++tick) {
      HapticSample sample = Sample(tick, 0);
      sample.tools[1].device_valid = tick < 100 || tick >= 250;
      samples.Push(sample);
    }
  }
  std::vector<event_t> devices;
  const LogContents log = ReadLog(folder / "session.lcmlog");
  for (const event_t& event : log.events) {
    if (event.name.starts_with("device.")) devices.push_back(event);
  }
  ASSERT_EQ(devices.size(), 2u);
  EXPECT_EQ(devices[0].name, "device.lost");
  EXPECT_EQ(devices[0].time_ns, 100 * kPeriod);
  EXPECT_EQ(devices[0].severity, event_t::WARNING);
  EXPECT_TRUE(devices[0].text.starts_with("right: "));
  EXPECT_EQ(devices[1].name, "device.back");
  EXPECT_EQ(devices[1].time_ns, 250 * kPeriod);
}

TEST(TelemetryLoop, AnInvertedOrganIsTwoEventsHoweverOftenItInverts) {
  const ScratchFolder folder;
  {
    SpscQueue<HapticSample> samples(4);
    StepEdges edges(1024);
    TelemetryLoop telemetry(&samples, &edges.steps, &edges.scenes, folder / "session.lcmlog", {},
                            TwoProbesAndALiver());
    for (std::uint64_t n = 1; n <= 60; ++n) {
      StepSample sample;
      sample.step.number = n;
      sample.step.time_ns = static_cast<Nanoseconds>(n) * 33 * kPeriod;
      sample.organ_count = 1;
      sample.organs[0].inverted = n >= 10 && n < 20 && n % 2 == 0;
      sample.organs[0].recovering = n >= 40;
      edges.steps.Push(sample);
    }
  }
  std::vector<event_t> organs;
  const LogContents log = ReadLog(folder / "session.lcmlog");
  for (const event_t& event : log.events) {
    if (event.name.starts_with("organ.")) organs.push_back(event);
  }
  ASSERT_EQ(organs.size(), 3u);
  EXPECT_EQ(organs[0].name, "organ.inverted");
  EXPECT_EQ(organs[0].time_ns, 10 * 33 * kPeriod);
  EXPECT_EQ(organs[0].severity, event_t::WARNING);
  EXPECT_TRUE(organs[0].text.starts_with("liver: tissue is turned inside out"));
  EXPECT_EQ(organs[1].name, "organ.recovered");
  EXPECT_EQ(organs[1].time_ns, 26 * 33 * kPeriod) << "0.25 s after step 18";
  EXPECT_EQ(organs[1].severity, event_t::INFO);
  EXPECT_EQ(organs[2].name, "organ.inverted");
  EXPECT_TRUE(organs[2].text.starts_with("liver: its tools ask for more"));
}

TEST(TelemetryLoop, WhatStepsShedIsAnEventALevel) {
  const ScratchFolder folder;
  {
    SpscQueue<HapticSample> samples(4);
    StepEdges edges(1024);
    TelemetryLoop telemetry(&samples, &edges.steps, &edges.scenes, folder / "session.lcmlog", {},
                            TwoProbesAndALiver());
    for (std::uint64_t n = 1; n <= 60; ++n) {
      StepSample sample;
      sample.step.number = n;
      sample.step.time_ns = static_cast<Nanoseconds>(n) * 33 * kPeriod;
      sample.step.shed_level = n < 10 || n >= 50 ? 0 : n < 20 || n >= 40 ? 1 : 2;
      if (sample.step.shed_level > 0) sample.step.flags = kStepShed;
      edges.steps.Push(sample);
    }
  }
  std::vector<std::string> names;
  const LogContents log = ReadLog(folder / "session.lcmlog");
  for (const event_t& event : log.events) {
    if (event.name.starts_with("steps.")) names.push_back(event.name);
  }
  EXPECT_EQ(names, (std::vector<std::string>{"steps.shed", "steps.shed", "steps.raised",
                                             "steps.restored"}));
}

int OpenSockets() {
  int sockets = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    std::error_code ignored;
    const std::string target = std::filesystem::read_symlink(entry, ignored).string();
    sockets += target.starts_with("socket:");
  }
  return sockets;
}

TEST(TelemetryLoop, OpensNoSocketUnlessLive) {
  const ScratchFolder folder;
  const int before = OpenSockets();
  SpscQueue<HapticSample> samples(16);
  StepEdges edges;
  TelemetryLoop telemetry(&samples, &edges.steps, &edges.scenes, folder / "session.lcmlog", {},
                          TwoProbesAndALiver());
  samples.Push(Sample(0, 0));
  telemetry.Drain();
  EXPECT_EQ(OpenSockets(), before);
}

// The thread edges as a session has them: samples and snapshots come from two threads while the
// telemetry runs on its own. Nothing is lost, and ThreadSanitizer sees every access.
TEST(TelemetryLoop, LosesNothingBetweenThreads) {
  constexpr std::uint64_t kTicks = 300;
  constexpr std::uint64_t kSteps = 10;
  constexpr std::uint64_t kFrames = 15;
  const ScratchFolder folder;
  SpscQueue<HapticSample> samples(1024);
  SpscQueue<FrameRecord> frames(1024);
  StepEdges edges;
  TelemetryOptions options;
  options.frames = &frames;
  TelemetryLoop telemetry(&samples, &edges.steps, &edges.scenes, folder / "session.lcmlog", options,
                          TwoProbesAndALiver());
  {
    std::jthread reader([&](std::stop_token stop) { telemetry.Run(stop); });
    {
      std::jthread deformation([&] {
        for (std::uint64_t n = 1; n <= kSteps; ++n) {
          edges.Publish(n, 33 * n);
          std::this_thread::sleep_for(std::chrono::milliseconds(30));
        }
      });
      std::jthread render([&] {
        for (std::uint64_t n = 1; n <= kFrames; ++n) {
          frames.Push({.time_ns = static_cast<Nanoseconds>(n) * 30 * kPeriod, .compute_ns = 7});
          std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
      });
      std::jthread haptic([&] {
        for (std::uint64_t tick = 0; tick < kTicks; ++tick) {
          samples.Push(Sample(tick, 0));
          std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
      });
    }
    reader.request_stop();
  }
  const LogContents log = ReadLog(folder / "session.lcmlog");
  ASSERT_EQ(log.ticks.size(), kTicks);
  for (std::uint64_t tick = 0; tick < kTicks; ++tick) EXPECT_EQ(log.ticks[tick].tick, tick);
  const TelemetrySummary summary = telemetry.Summary();
  EXPECT_EQ(summary.session.steps, kSteps);
  EXPECT_EQ(log.contacts.size(), kSteps);
  EXPECT_EQ(summary.queue_overflows, 0u);
  EXPECT_EQ(summary.session.frames, kFrames);
  std::int64_t logged_frames = 0;
  for (const stats_t& stats : log.stats) logged_frames += stats.render.cycles;
  EXPECT_EQ(logged_frames, static_cast<std::int64_t>(kFrames));
}

TEST(TelemetryLoop, TheMachinesOwnLatenessAndTheTimeItLostStandBesideTheSessions) {
  const ScratchFolder folder;
  TelemetryOptions options;
  for (int i = 1; i <= 1000; ++i) options.baseline.Add(10 * i);
  // The host takes 20 ms a second; its count starts anywhere, and once steps back.
  const Nanoseconds stolen[] = {500, 520, 540, 530, 560};
  int asked = 0;
  options.stolen_time = [&] { return stolen[asked++] * kPeriod; };
  const TelemetrySummary summary = RunLockstep(folder / "session.lcmlog", options, 3500);
  EXPECT_EQ(asked, 5) << "at the start, and once a second";
  EXPECT_EQ(summary.session.stolen_ns, 60 * kPeriod);
  EXPECT_EQ(summary.session.latencies[Latency::kBaselineWakeUp].count(), 1000u);
  const LogContents log = ReadLog(folder / "session.lcmlog");
  ASSERT_EQ(log.stats.size(), 4u);
  const std::int64_t expected[] = {20, 20, 0, 20};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(log.stats[i].stolen_ns, expected[i] * kPeriod) << i;
    EXPECT_EQ(log.stats[i].latencies[stats_t::BASELINE_WAKE_UP].max_ns, 10'000);
  }
  EXPECT_EQ(log.events[1].name, "realtime.baseline");
  EXPECT_NE(log.events[1].text.find("10.0 us at most"), std::string::npos) << log.events[1].text;
}

/// What arrived, in the order of its sequence numbers.
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

TEST(TelemetryLoop, LivePublishesEveryMessageAndRepeatsTheMesh) {
  if (!InsideNetworkNamespace()) {
    const std::string enter = NetworkNamespaceCommand();
    if (enter.empty()) GTEST_SKIP() << "network namespaces are refused here";
    EXPECT_EQ(
        RunInNetworkNamespace(enter, "TelemetryLoop.LivePublishesEveryMessageAndRepeatsTheMesh"),
        0);
    return;
  }
  lcm::LCM lcm(std::string(kLocalUrl) + "&recv_buf_size=4000000");
  ASSERT_TRUE(lcm.good());
  Receiver receiver;
  Subscribe<tool_t>(&lcm, kToolChannel, &receiver);
  Subscribe<force_t>(&lcm, kForceChannel, &receiver);
  Subscribe<contact_t>(&lcm, kContactChannel, &receiver);
  Subscribe<organ_t>(&lcm, kOrganChannel, &receiver);
  Subscribe<mesh_t>(&lcm, kMeshChannel, &receiver);
  Subscribe<stats_t>(&lcm, kStatsChannel, &receiver);
  Subscribe<event_t>(&lcm, kEventChannel, &receiver);

  constexpr std::uint64_t kTicks = 1100;
  const ScratchFolder folder;
  SpscQueue<HapticSample> samples(64);
  StepEdges edges;
  TelemetryOptions options;
  options.live = true;
  options.mesh_repeat = kNanosecondsPerSecond / 2;
  TelemetryLoop telemetry(&samples, &edges.steps, &edges.scenes, folder / "session.lcmlog", options,
                          TwoProbesAndALiver());
  for (std::uint64_t tick = 0; tick < kTicks; ++tick) {
    if (tick % 40 == 0) edges.Publish(tick / 40 + 1, tick);
    samples.Push(Sample(tick, tick / 40 + 1, tick / 40 * 40));
    telemetry.Drain();
    while (lcm.handleTimeout(0) > 0) {
    }
  }
  telemetry.Finish();
  while (lcm.handleTimeout(200) > 0) {
  }
  const TelemetrySummary summary = telemetry.Summary();
  EXPECT_EQ(summary.live_errors, 0u);
  EXPECT_EQ(receiver.last_sequence[kToolChannel], static_cast<std::int64_t>(kTicks));
  EXPECT_EQ(receiver.last_sequence[kForceChannel], static_cast<std::int64_t>(kTicks));
  EXPECT_EQ(receiver.last_sequence[kContactChannel], 28);
  EXPECT_EQ(receiver.last_sequence[kOrganChannel], 28);
  EXPECT_EQ(receiver.last_sequence[kStatsChannel], 2);
  const auto parts = static_cast<std::size_t>(receiver.meshes.at(0).part_count);
  ASSERT_EQ(receiver.meshes.size(), 3 * parts) << "at 0, 0.5 and 1 s";
  for (std::size_t repeat = 0; repeat < 3; ++repeat) {
    OrganDescription organ;
    std::string error;
    EXPECT_TRUE(JoinMesh({&receiver.meshes[repeat * parts], parts}, &organ, &error)) << error;
  }
  // A link to an external driver publishes the forces itself: nobody hears them twice.
  options.forces_linked = true;
  {
    TelemetryLoop linked(&samples, &edges.steps, &edges.scenes, folder / "linked.lcmlog", options,
                         TwoProbesAndALiver());
    receiver = {};
    for (std::uint64_t tick = 0; tick < 50; ++tick) samples.Push(Sample(tick, 0));
  }
  while (lcm.handleTimeout(200) > 0) {
  }
  EXPECT_EQ(receiver.last_sequence[kToolChannel], 50);
  EXPECT_EQ(receiver.last_sequence.count(kForceChannel), 0u);
  EXPECT_EQ(ReadLog(folder / "linked.lcmlog").ticks.size(), 50u);

  // The log holds the mesh once and everything else as it was published.
  const LogContents log = ReadLog(folder / "session.lcmlog");
  EXPECT_EQ(log.meshes.size(), parts);
  EXPECT_EQ(log.ticks.size(), kTicks);
}

}  // namespace
}  // namespace hpdm
