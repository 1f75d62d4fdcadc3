#include "render/tissue/burn_marks.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace hpdm {
namespace {

// Two organs, the second a row of vertices 1 mm apart along x and moved by 20 mm along y, and a hook whose
// pedal is pressed on its sixth vertex.
struct HookOnARow {
  HookOnARow() {
    snapshot.organs.resize(2);
    snapshot.organs[0].vertices.setZero(3, 3);
    snapshot.organs[1].vertices.setZero(11, 3);
    for (int v = 0; v < 11; ++v) snapshot.organs[1].vertices(v, 0) = 0.001f * static_cast<float>(v);
    snapshot.organs[1].offset_W.y() = 0.02;
    snapshot.tool_count = 1;
    snapshot.burns[0] = true;
    snapshot.contacts[0].organ = 1;
    snapshot.contacts[0].kind = ContactKind::kPress;
    snapshot.contacts[0].contact_W = Vector3d(0.005, 0.02, 0);
  }
  bool At(double seconds) {
    snapshot.step.time_ns = static_cast<Nanoseconds>(seconds * 1e9);
    return marks.Follow(snapshot);
  }
  SceneSnapshot snapshot;
  BurnMarks marks{{3, 11}};
};

TEST(BurnMarks, GrowByTimeWhereTheHookPresses) {
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
  hook.snapshot.contacts[0].contact_W.x() = 0.1;
  EXPECT_FALSE(hook.At(3));
  EXPECT_EQ(black[5], 1) << "it stays";
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
