#include <gtest/gtest.h>

#include "tests/support/haptic_bench.h"

/// Tests a trainee's requests to the haptic loop: pauses and exchanges of instruments.
namespace hpdm {
namespace {

constexpr double kThick = 0.005;  // m, tip radius

SessionControl Take(int instrument_index) {
  return {.paused = false, .instrument_index = {instrument_index, 0}};
}

class SessionControlTest : public testing::Test {
 protected:
  // Runs ticks with fresh patches; at least one tick.
  HapticSample Run(int ticks) {
    HapticSample sample;
    for (int i = 0; i < ticks; ++i) {
      if (i % 33 == 0) bench_.PublishPatch();
      sample = bench_.Tick();
    }
    return sample;
  }

  Bench bench_{true, {{.tip_radius = kThick}}};
};

TEST_F(SessionControlTest, AnExchangeWaitsUntilTheTipIsFree) {
  bench_.device.MoveTip({0, 0, 0.001});
  EXPECT_EQ(Run(600).tools[0].kind, ContactKind::kPress);
  bench_.Ask(Take(1));
  EXPECT_EQ(Run(100).tools[0].instrument_index, 0);
  bench_.device.MoveTip({0, 0, 0.01});
  EXPECT_EQ(bench_.Tick().tools[0].instrument_index, 0) << "the tick that finds it free";
  EXPECT_EQ(bench_.Tick().tools[0].instrument_index, 1);
  bench_.tool_states.Update();
  EXPECT_EQ(bench_.tool_states.Front().tools[0].instrument_index, 1);
}

TEST_F(SessionControlTest, TheNewTipIsFeltByItsOwnRadiusAndPatchesAndWithoutAStep) {
  const double height = 0.004;  // between the two radii
  bench_.device.MoveTip({0, 0, height});
  EXPECT_EQ(Run(600).tools[0].kind, ContactKind::kNone);
  bench_.Ask(Take(1));
  EXPECT_EQ(Run(34).tools[0].kind, ContactKind::kNone) << "the patches are the old tip's";
  bench_.instrument_index = 1;
  double last = 0;
  HapticSample sample;
  for (int i = 0; i < 600; ++i) {
    if (i % 33 == 0) bench_.PublishPatch();
    sample = bench_.Tick();
    const double force = sample.tools[0].force_W.norm();
    // 0.12 N come in over half a second, beside what the first 34 ticks had ramped in: a twelfth.
    EXPECT_LT(force - last, 0.012);
    last = force;
  }
  EXPECT_EQ(sample.tools[0].kind, ContactKind::kPress);
  EXPECT_NEAR(sample.tools[0].depth, kThick - height, 1e-6);
  // The plane's triangles are exact; the inverse kinematics round the height to a nanometre.
  EXPECT_NEAR(last, kStiffness * (kThick - height), 1e-4);
}

// Until a step knows of the restart its patches hold the tissue of before.
TEST_F(SessionControlTest, ARestartLetsGoAtTheSlewLimitAndTheForceRampsIn) {
  bench_.stiffness = 2000;
  bench_.device.MoveTip({0, 0, 0.0005});
  const double full = Run(700).tools[0].force_W.norm();
  ASSERT_GT(full, 3);
  bench_.PublishPatch();  // of a step that did not know
  SessionControl asked;
  asked.restart = {1, 2};
  bench_.Ask(asked);
  double last = full;
  for (int i = 0; i < 10; ++i) {
    const HapticSample sample = bench_.Tick();
    EXPECT_EQ(sample.restart.count, 1);
    EXPECT_EQ(sample.tools[0].kind, ContactKind::kNone);
    const double force = sample.tools[0].force_W.norm();
    EXPECT_LE(std::abs(force - last), 2 + 1e-9) << "2000 N/s";
    last = force;
  }
  EXPECT_EQ(last, 0);
  bench_.tool_states.Update();
  EXPECT_EQ(bench_.tool_states.Front().restart.step, 2);
  HapticSample sample;
  for (int i = 0; i < 600; ++i) {
    if (i % 33 == 0) bench_.PublishPatch();
    sample = bench_.Tick();
    const double force = sample.tools[0].force_W.norm();
    EXPECT_LT(force - last, 0.02 * full) << "half a second to full force";
    last = force;
  }
  EXPECT_EQ(sample.tools[0].kind, ContactKind::kPress);
  EXPECT_NEAR(last, full, 1e-3 * full);
}

TEST_F(SessionControlTest, AnInstrumentThatTheHandDoesNotHaveIsIgnored) {
  for (const int instrument_index : {-1, 2, 1 << 30}) {
    bench_.Ask(Take(instrument_index));
    EXPECT_EQ(Run(10).tools[0].instrument_index, 0) << instrument_index;
  }
}

TEST_F(SessionControlTest, APauseFadesTheForceThatRampsInAfterwards) {
  bench_.device.MoveTip({0, 0, 0.001});
  const HapticSample before = Run(700);
  const double full = before.tools[0].force_W.norm();
  ASSERT_GT(full, 0.1);
  bench_.Ask({.paused = true, .instrument_index = {}});
  double last = full;
  for (int i = 0; i < 300; ++i) {
    bench_.device.MoveTip({0.01, 0, 0});  // whatever the hand does then
    if (i % 33 == 0) bench_.PublishPatch();
    const HapticSample sample = bench_.Tick();
    const double force = sample.tools[0].force_W.norm();
    EXPECT_TRUE(sample.paused);
    EXPECT_NE(sample.tools[0].guard_flags & kGuardPaused, 0u);
    EXPECT_TRUE(sample.tools[0].force_on) << "the device would display it";
    EXPECT_EQ(sample.tools[0].joints, before.tools[0].joints);
    EXPECT_EQ(sample.tools[0].v_tip_W.norm(), 0);
    EXPECT_EQ(sample.device_time_ns, before.device_time_ns);
    // A time constant of 50 ms: 2 % a tick.
    EXPECT_LE(force, last);
    EXPECT_GT(force, 0.97 * last);
    last = force;
  }
  EXPECT_LT(last, 0.01 * full);

  bench_.Ask({});
  HapticSample sample = Run(1);
  EXPECT_FALSE(sample.paused);
  EXPECT_NEAR(sample.tools[0].p_tip_W.x(), 0.01, 1e-6) << "where the hand is now";
  EXPECT_EQ(sample.tools[0].v_tip_W.norm(), 0) << "the pause's motion is none of the tool's";
  for (int i = 0; i < 600; ++i) {
    last = sample.tools[0].force_W.norm();
    if (i % 33 == 0) bench_.PublishPatch();
    sample = bench_.Tick();
    // 0.3 N over 500 ticks are 0.6 mN a tick.
    EXPECT_LT(sample.tools[0].force_W.norm() - last, 0.002);
  }
  EXPECT_NEAR(sample.tools[0].force_W.norm(), kStiffness * kTipRadius, 0.01);
}

TEST_F(SessionControlTest, APauseBeforeTheFirstReadingLeavesTheToolAtItsTrocar) {
  bench_.Ask({.paused = true, .instrument_index = {}});
  const HapticSample sample = Run(10);
  EXPECT_FALSE(sample.tools[0].device_valid);
  EXPECT_NEAR((sample.tools[0].p_tip_W - kTrocar).norm(), DeviceProfile().min_insertion, 1e-9);
  EXPECT_EQ(sample.tools[0].force_W.norm(), 0);
}

TEST_F(SessionControlTest, ThePedalIsPressedAtTheDeviceOrInTheWindow) {
  EXPECT_FALSE(Run(10).tools[0].pedal);
  bench_.device.pedal = true;
  EXPECT_TRUE(Run(1).tools[0].pedal);
  bench_.tool_states.Update();
  EXPECT_TRUE(bench_.tool_states.Front().tools[0].pedal);
  bench_.device.pedal = false;
  EXPECT_FALSE(Run(1).tools[0].pedal);
  bench_.Ask({.pedal = {true, false}});
  EXPECT_TRUE(Run(1).tools[0].pedal);
  bench_.Ask({.pedal = {false, true}});
  EXPECT_FALSE(Run(1).tools[0].pedal) << "the other hand's";
}

TEST_F(SessionControlTest, ThePedalIsOffAfterFiveMillisecondsWithoutAReading) {
  for (const bool at_device : {true, false}) {
    bench_.device.pedal = at_device;
    bench_.Ask({.pedal = {!at_device, false}});
    bench_.device.age = 5'000'000;
    EXPECT_TRUE(Run(1).tools[0].pedal);
    bench_.device.age = 5'000'001;
    EXPECT_FALSE(Run(1).tools[0].pedal);
    bench_.device.age = 0;
    bench_.device.valid = false;
    EXPECT_FALSE(Run(1).tools[0].pedal);
    bench_.device.valid = true;
    EXPECT_TRUE(Run(1).tools[0].pedal);
  }
}

TEST_F(SessionControlTest, APauseReleasesThePedal) {
  bench_.device.pedal = true;
  bench_.Ask({.paused = true, .pedal = {true, false}});
  EXPECT_FALSE(Run(2).tools[0].pedal);
  bench_.Ask({.paused = false, .pedal = {true, false}});
  EXPECT_TRUE(Run(1).tools[0].pedal);
}

}  // namespace
}  // namespace hpdm
