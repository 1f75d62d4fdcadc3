#include "haptics/device/trace_device.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "haptics/haptic_loop.h"
#include "tests/support/contact_patches.h"
#include "tests/support/counted_allocations.h"
#include "tests/support/mesh_shapes.h"
#include "tests/support/scratch_folder.h"

namespace hpdm {
namespace {

constexpr Nanoseconds kMs = 1'000'000;
constexpr double kTipRadius = 0.0025;
const Vector3d kTrocar(0, 0, 0.1);

ImpulseEngineKinematics Kinematics() { return {kTrocar, -Vector3d::UnitZ(), DeviceProfile{}}; }

TraceFile TipFile(const std::vector<std::pair<double, Vector3d>>& rows) {
  TraceFile file;
  file.place = TracePlace::kTip;
  for (const auto& [t, p] : rows) {
    TraceRow& row = file.rows.emplace_back();
    row.time_ns = std::llround(t * 1e9);
    row.values << p, 0, 1;
  }
  return file;
}

TraceDevice Device(const TraceFile& file, const TraceMapping& mapping = {}) {
  return {file, TraceMotion(file.rows), mapping, Kinematics()};
}

Vector3d Tip(const DeviceSample& sample) {
  return Kinematics().Forward(sample.joints).translation();
}

/// A hand that pokes from 30 mm above the plane to 10 mm below and back, at 1 m/s, every 0.2 s.
TraceFile Pokes(int count) {
  std::vector<std::pair<double, Vector3d>> rows;
  for (int i = 0; i < 200 * count; ++i) {
    const double t = 1e-3 * (i % 200);
    const double down = t < 0.04 ? t : std::max(0.0, 0.08 - t);
    rows.push_back({1e-3 * i, {0.001, 0, 0.03 - down}});
  }
  return TipFile(rows);
}

TEST(TraceDevice, TheTipIsTheFilesByScaleRotationAndPosition) {
  TraceMapping mapping;
  mapping.scale = 1e-3;
  mapping.R_WF << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  mapping.position_W = {0.01, -0.02, 0.005};
  TraceDevice device = Device(TipFile({{0, {10, 20, 1}}, {1, {12, 20, 1}}}), mapping);
  const DeviceSample sample = device.Read(0);
  EXPECT_TRUE(sample.valid);
  EXPECT_LT((Tip(sample) - Vector3d(-0.01, -0.01, 0.006)).norm(), 1e-15);
  EXPECT_EQ(device.ClampedShare(), 0);
}

TEST(TraceDevice, StartsAtItsFirstReadAndHoldsItsEnd) {
  TraceDevice device = Device(TipFile({{0, {0, 0, 0.02}}, {0.04, {0, 0, 0.01}}}), {.speed = 2});
  EXPECT_EQ(device.duration(), 20 * kMs);
  const Nanoseconds start = 12345 * kMs;
  EXPECT_NEAR(Tip(device.Read(start)).z(), 0.02, 1e-15);
  const DeviceSample middle = device.Read(start + 10 * kMs);
  EXPECT_EQ(middle.time_ns, start + 10 * kMs);
  EXPECT_EQ(middle.sequence, 2u);
  EXPECT_NEAR(Tip(middle).z(), 0.015, 1e-15);
  EXPECT_NEAR(Tip(device.Read(start + 3600'000 * kMs)).z(), 0.01, 1e-15);
  device.Home();
  EXPECT_NEAR(Tip(device.Read(start)).z(), 0.02, 1e-15) << "homing goes back to the start";
}

TEST(TraceDevice, AFittedTraceTouchesItsDepthOnceAndGoesNoDeeper) {
  const Vector3d n = Vector3d(0.1, -0.2, 1).normalized(), deepest(0.01, 0.02, -0.015);
  const TraceFile file =
      TipFile({{0, {5, 6, 7.001}}, {0.1, {5.001, 6.002, 7}}, {0.2, {5.003, 6, 6.99}}});
  TraceMapping mapping;
  mapping.R_WF = Eigen::AngleAxisd(0.3, Vector3d::UnitX()).toRotationMatrix();
  mapping.scale = 0.5;
  const TraceMotion motion(file.rows);
  mapping = Fitted(mapping, motion, deepest, n);
  double closest = 1;
  for (const TraceRow& row : file.rows) {
    const Vector3d p = mapping.Apply(row.values.head<3>());
    // 1e-15: rounding of coordinates of a few metres.
    EXPECT_GE((p - deepest).dot(n), -1e-15);
    closest = std::min(closest, (p - deepest).norm());
  }
  EXPECT_LT(closest, 1e-15);
}

TEST(TraceDevice, PosesOutOfReachAreClampedAndCounted) {
  // Insertion reaches from 20 to 300 mm; one row of four is at the trocar, one 1 m away.
  TraceDevice device = Device(
      TipFile({{0, {0, 0, 0}}, {0.1, {0, 0, 0.1}}, {0.2, {0, 0, -0.9}}, {0.3, {0, 0, -0.1}}}));
  EXPECT_EQ(device.ClampedShare(), 0.5);
  for (Nanoseconds t = 0; t <= 400 * kMs; t += kMs) {
    const JointVector joints = device.Read(t).joints;
    ASSERT_TRUE((joints.array() >= device.limits().min_joints.array()).all());
    ASSERT_TRUE((joints.array() <= device.limits().max_joints.array()).all());
  }
}

TEST(TraceDevice, JointsAreTheDevicesOwnAndNoMappingMovesThem) {
  TraceFile file;
  file.place = TracePlace::kJoints;
  file.rows.resize(2);
  file.rows[0].values << 0.1, -0.2, 0.05, 0.3, 0.5;
  file.rows[1].values << 2, -0.2, 0.05, 0.3, 0.5;
  file.rows[1].time_ns = kMs;
  TraceDevice device = Device(file, {.scale = 7, .position_W = Vector3d::Ones()});
  EXPECT_EQ(device.Read(0).joints, file.rows[0].values);
  EXPECT_EQ(device.Read(kMs).joints[kPitch], DeviceProfile{}.max_angle);
  EXPECT_EQ(device.ClampedShare(), 0.5);
}

TEST(TraceDevice, ForceHasNoEffectOnIt) {
  TraceDevice free = Device(Pokes(1)), pushed = Device(Pokes(1));
  pushed.Home();
  pushed.EnableForce(true);
  EXPECT_TRUE(pushed.ForceOn());
  for (Nanoseconds t = 0; t < 200 * kMs; t += kMs) {
    pushed.Write({1, 1, 8});
    ASSERT_EQ(free.Read(t).joints, pushed.Read(t).joints);
  }
}

TEST(TraceDevice, ReadAllocatesNothing) {
  if (!kCountsAllocations) GTEST_SKIP() << "sanitizers bring their own allocator";
  TraceDevice device = Device(Pokes(5));
  const long before = AllocationsOfThisThread();
  for (Nanoseconds t = 0; t < 1000 * kMs; t += kMs) device.Read(t);
  EXPECT_EQ(AllocationsOfThisThread(), before);
}

/// Runs a trace through the haptic loop over a plane at z = 0 with 120 N/m, in virtual time.
std::vector<HapticSample> Play(TraceDevice* device, int ticks) {
  device->Home();
  device->EnableForce(true);
  TripleBuffer<ToolState> tool_states;
  TripleBuffer<ContactPatch> patches;
  SpscQueue<HapticSample> samples(64);
  HapticLoop loop({{device, Kinematics(), {{.tip_radius = kTipRadius}}}}, kMs,
                  {tool_states, patches, samples});
  std::vector<HapticSample> log;
  for (int tick = 0; tick < ticks; ++tick) {
    if (tick % 33 == 0) {
      ContactPatch& patch = patches.Back();
      patch = {};
      patch.step.number = static_cast<std::uint64_t>(tick / 33 + 1);
      patch.step.device_time_ns = tick * kMs;
      patch.tool_count = 1;
      patch.tools[0].places[0] = PlanePatch(7, 0.03, 120);
      patches.Publish();
    }
    loop.Tick(static_cast<std::uint64_t>(tick), tick * kMs, {});
    EXPECT_TRUE(samples.Pop(&log.emplace_back()));
  }
  return log;
}

TEST(TraceDevice, EveryPokeAtAMetreASecondIsFeltAndLeftAgain) {
  TraceDevice device = Device(Pokes(8));
  const std::vector<HapticSample> log = Play(&device, 1600);
  double fastest = 0;
  for (int poke = 4; poke < 8; ++poke) {  // from 0.8 s on: past the guard's ramp of 0.5 s
    double deepest = 0, peak = 0;
    int felt = 0;
    for (int i = 200 * poke; i < 200 * (poke + 1); ++i) {
      const ToolSample& tool = log[static_cast<std::size_t>(i)].tools[0];
      deepest = std::max(deepest, tool.depth);
      peak = std::max(peak, tool.force_W.z());
      felt += tool.kind == ContactKind::kPress;
      fastest = std::max(fastest, tool.v_tip_W.norm());
      // A tick after the tip's sphere has left the plane nothing is felt.
      if (tool.p_tip_W.z() > kTipRadius) {
        EXPECT_EQ(tool.reaction_W, Vector3d::Zero());
      }
    }
    // The tip turns at 10 mm below, its sphere 2.5 mm deeper; 1.5 N by 120 N/m. A sample taken a
    // tick beside the turn would be 1 mm less.
    EXPECT_NEAR(deepest, 0.0125, 0.001);
    EXPECT_NEAR(peak, 1.5, 0.12);
    EXPECT_NEAR(felt, 25, 2) << "12.5 mm in and out at a millimetre a tick";
  }
  EXPECT_GT(fastest, 0.9);
}

std::string SharedTrace(const std::string& name) { return kDataFolder + "traces/" + name; }

TEST(TraceDevice, RecordedTwoArmMotionIsBridgedSmoothAndNoStaircase) {
  for (const char* name : {"desk_taurus_S10_T1_left.csv", "desk_taurus_S10_T1_right.csv"}) {
    const std::string path = SharedTrace(name);
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "no shared data: " << path;
    const TraceFile file = ReadTraceFile(path);
    EXPECT_EQ(file.rows.size(), 6796u);
    const TraceMotion motion(file.rows);
    EXPECT_EQ(motion.gaps().count, 1u);
    EXPECT_NEAR(ToSeconds(motion.gaps().longest_ns), 1.656094, 1e-9);
    EXPECT_EQ(motion.duration(), 28'827'648'000);
    // About half the rows repeat the one before.
    EXPECT_NEAR(static_cast<double>(motion.places().size()) / 6796, 0.5, 0.1);
    // The raw rows jump at up to 89 mm/s over 4 ms where the hand moved for 8.
    EXPECT_LT(motion.fastest(), 0.06);

    // If the hand moves for a tenth of a second, it moves in every millisecond of it.
    TraceMotion::Cursor cursor;
    int moving = 0, still = 0;
    Vector3d last = motion.At(0, &cursor).head<3>();
    std::vector<double> speeds;
    for (Nanoseconds t = kMs; t < motion.duration(); t += kMs) {
      const Vector3d p = motion.At(t, &cursor).head<3>();
      speeds.push_back((p - last).norm() / 1e-3);
      last = p;
      ASSERT_LT(speeds.back(), 2 * motion.fastest());
    }
    for (std::size_t i = 50; i + 50 < speeds.size(); ++i) {
      double mean = 0;
      for (std::size_t k = i - 50; k < i + 50; ++k) mean += speeds[k] / 100;
      if (mean < 0.02) continue;
      ++moving;
      still += speeds[i] < 0.1 * mean;
    }
    if (std::string(name).find("right") != std::string::npos) {
      EXPECT_GT(moving, 1000);
    }
    // A turn of direction passes through rest; a staircase would rest in half of the time.
    EXPECT_LE(still, 0.02 * moving);
  }
}

// haptics/README.md gives this command for the spindle's encoder of 8192 counts a turn.
TEST(TraceDevice, ARecordedSpindleDrivesTheRollThroughTheHapticLoop) {
  const std::string path = SharedTrace("mis_davinci_maryland_L2_00.txt");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no shared data: " << path;
  const ScratchFolder folder;
  const std::string command =
      "awk -F, 'BEGIN { print \"t,roll\" } /^[0-9]/ { printf \"%s,%.6f\\n\", $1, $2 * 6.283185307 "
      "/ "
      "8192 }' " +
      path + " > " + (folder / "roll.csv");
  ASSERT_EQ(std::system(command.c_str()), 0);
  const TraceFile file = ReadTraceFile(folder / "roll.csv");
  EXPECT_EQ(file.place, TracePlace::kNone);
  ASSERT_EQ(file.rows.size(), 19994u);
  const TraceMotion motion(file.rows);
  TraceDevice device(file, motion, {.position_W = {0, 0, 0.02}}, Kinematics());
  const std::vector<HapticSample> log = Play(&device, 19994);
  double least = 10, most = -10;
  for (std::size_t i = 0; i < log.size(); ++i) {
    const ToolSample& tool = log[i].tools[0];
    // There is one row per tick. Rows without repeats are met exactly, repeats within the encoder's
    // count of 0.77 mrad, since the hand moved meanwhile.
    ASSERT_NEAR(tool.joints[kRoll], file.rows[i].values[kRoll], 0.77e-3 * 1.01) << i;
    ASSERT_LT((tool.p_tip_W - Vector3d(0, 0, 0.02)).norm(), 1e-15) << "the tip stands still";
    least = std::min(least, tool.joints[kRoll]);
    most = std::max(most, tool.joints[kRoll]);
  }
  // The file's header says a sine of 30 degrees amplitude, which the spindle follows within a
  // degree.
  EXPECT_NEAR(most - least, 60 * M_PI / 180, 0.04);
}

}  // namespace
}  // namespace hpdm
