#include "render/tissue/burn_marks.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace hpdm {
namespace {

constexpr int kRow = 11;

// Two strips, the second with a row of vertices 1 mm apart along x, another 20 mm behind it along -y,
// moved by 20 mm along y. A hook's tip, 1.5 mm above the sixth vertex of the row, presses it with the pedal
// down. Its contact is where friction holds it, 5 mm away.
struct HookOnARow {
  HookOnARow() {
    snapshot.organs.resize(2);
    for (OrganSnapshot& organ : snapshot.organs) {
      organ.vertices.setZero(2 * kRow, 3);
      for (int v = 0; v < 2 * kRow; ++v) {
        organ.vertices(v, 0) = 0.001f * static_cast<float>(v % kRow);
        organ.vertices(v, 1) = v < kRow ? 0 : -0.02f;
      }
    }
    snapshot.organs[1].offset_W.y() = 0.02;
    snapshot.tool_count = 1;
    snapshot.burns[0] = true;
    snapshot.contacts[0].organ = 1;
    snapshot.contacts[0].kind = ContactKind::kPress;
    snapshot.contacts[0].contact_W = Vector3d(0.010, 0.02, 0);
    snapshot.tools[0].X_WT.translation() = Vector3d(0.005, 0.02, 0.0015);
  }
  bool At(double seconds) {
    snapshot.step.time_ns = static_cast<Nanoseconds>(seconds * 1e9);
    return marks.Follow(snapshot);
  }
  static Triangles Strip() {
    Triangles triangles(2 * (kRow - 1), 3);
    for (int v = 0; v + 1 < kRow; ++v) {
      triangles.row(2 * v) << v, kRow + v, v + 1;
      triangles.row(2 * v + 1) << v + 1, kRow + v, kRow + v + 1;
    }
    return triangles;
  }
  SceneSnapshot snapshot;
  BurnMarks marks{{Strip(), Strip()}, {2 * kRow, 2 * kRow}};
};

TEST(BurnMarks, GrowByTimeUnderTheTip) {
  HookOnARow hook;
  hook.At(0);
  for (int step = 1; step <= 6; ++step) EXPECT_TRUE(hook.At(step / 30.0));
  const std::vector<float>& black = hook.marks.Of(1);
  EXPECT_NEAR(black[5], 0.2 / BurnMarks::kTime, 1e-5);
  EXPECT_NEAR(black[7], 0.5 * black[5], 1e-5) << "2 of 4 mm away";
  EXPECT_NEAR(black[3], black[7], 1e-6);
  EXPECT_NEAR(black[1], 0, 1e-6) << "4 mm away";
  EXPECT_EQ(black[0], 0);
  EXPECT_EQ(std::ranges::max(hook.marks.Of(0)), 0)
      << "the other organ lies in the hook's reach, too";
  for (int step = 7; step <= 60; ++step) hook.At(step / 30.0);
  EXPECT_EQ(black[5], 1);
  hook.snapshot.tools[0].X_WT.translation().z() = 0.0041;
  EXPECT_FALSE(hook.At(3)) << "the tip has left its contact";
  EXPECT_EQ(black[5], 1) << "it stays";
}

// In the middle of a triangle no corner of which is within reach.
TEST(BurnMarks, AreSeenOnALargeTriangle) {
  HookOnARow hook;
  hook.At(0);
  hook.snapshot.tools[0].X_WT.translation() = Vector3d(0.005, 0.01, 0.001);
  for (int step = 1; step <= 6; ++step) EXPECT_TRUE(hook.At(step / 30.0));
  const std::vector<float>& black = hook.marks.Of(1);
  EXPECT_NEAR(black[5] + black[kRow + 5], 0.2 / BurnMarks::kTime, 1e-5);
  EXPECT_NEAR(black[5], black[kRow + 5], 1e-5);
}

TEST(BurnMarks, NeedAPedalAPressAndALiveSession) {
  HookOnARow idle;
  idle.At(0);
  idle.snapshot.burns[0] = false;
  EXPECT_FALSE(idle.At(0.03));
  idle.snapshot.burns[0] = true;
  idle.snapshot.contacts[0].kind = ContactKind::kNone;
  EXPECT_FALSE(idle.At(0.06));
  idle.snapshot.contacts[0].kind = ContactKind::kPress;
  EXPECT_FALSE(idle.At(0.06)) << "no time has passed";
  EXPECT_TRUE(idle.At(10));
  EXPECT_NEAR(idle.marks.Of(1)[5], BurnMarks::kLongest / BurnMarks::kTime, 1e-6)
      << "a late picture";
}

}  // namespace
}  // namespace hpdm
