#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "lcmtypes/telemetry/telemetry_loop.h"
#include "lcmtypes/wire/codec.h"

namespace hpdm {

inline constexpr Nanoseconds kTickPeriod = 1'000'000;
inline constexpr int kControlPoints = 20;
inline constexpr int kPatchDelayTicks = 34;

inline SessionInfo TwoProbesAndALiver() {
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

inline SceneSnapshot EmptyScene() {
  SceneSnapshot scene;
  scene.organs.resize(1);
  scene.organs[0].control_displacements = Points::Zero(kControlPoints, 3);
  return scene;
}

/// Returns the sample of a tick. `patch_tick` is the first tick that used the patch.
inline HapticSample Sample(std::uint64_t tick, std::uint64_t patch_number,
                           std::uint64_t patch_tick = 0) {
  HapticSample sample;
  sample.tick = tick;
  sample.time_ns = static_cast<Nanoseconds>(tick) * kTickPeriod;
  sample.device_time_ns = sample.time_ns;
  sample.patch_number = patch_number;
  sample.patch_tick = patch_tick;
  sample.patch_age_ns = 20 * kTickPeriod;
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

/// The two queues from the deformation loop.
struct StepEdges {
  explicit StepEdges(std::size_t capacity = 64) : steps(capacity) {}

  void Publish(std::uint64_t number, std::uint64_t tick) {
    StepSample sample;
    sample.step.number = number;
    sample.step.input_tick = tick;
    sample.step.time_ns = static_cast<Nanoseconds>(tick) * kTickPeriod;
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

/// Runs a session in the lockstep clock. Step j starts at tick ceil(j 1000 / 30), and its patch is
/// visible kPatchDelayTicks later. The telemetry drains after every tick.
inline TelemetrySummary RunLockstep(const std::string& log_path, TelemetryOptions options,
                                    int ticks) {
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

/// The messages of a log, by channel.
struct LogContents {
  std::vector<HapticSample> ticks;  ///< From HPDM_TOOL and HPDM_FORCE.
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

/// Reads a log and expects it to be intact, in order and without gaps.
inline LogContents ReadLog(const std::string& path) {
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

}  // namespace hpdm
