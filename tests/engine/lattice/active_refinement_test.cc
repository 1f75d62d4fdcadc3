#include "engine/lattice/active_refinement.h"

#include <gtest/gtest.h>

#include <array>

namespace hpdm {
namespace {

TEST(ActiveRefinement, TakesTheNearestAndKeepsTheirSlots) {
  Points centres(100, 3);
  for (int a = 0; a < 100; ++a) centres.row(a) = Eigen::RowVector3d(a, 0, 0);
  ActiveRefinement active(100, 4);
  const Vector3d first[] = {Vector3d(10.4, 0, 0)};
  active.ChooseNearest(centres, first, 4);
  std::array<int, 4> slot{};
  for (int a = 9; a <= 12; ++a) {
    ASSERT_GE(active.Slot(a), 0) << a;
    EXPECT_EQ(active.Function(active.Slot(a)), a);
    EXPECT_TRUE(active.Changed(active.Slot(a)));
    slot[a - 9] = active.Slot(a);
  }
  const Vector3d moved[] = {Vector3d(11.4, 0, 0)};
  active.ChooseNearest(centres, moved, 4);
  EXPECT_EQ(active.Slot(9), -1);
  for (int a = 10; a <= 12; ++a) {
    EXPECT_EQ(active.Slot(a), slot[a - 9]);
    EXPECT_FALSE(active.Changed(active.Slot(a)));
  }
  EXPECT_EQ(active.Slot(13), slot[0]);
  EXPECT_TRUE(active.Changed(slot[0]));
}

TEST(ActiveRefinement, TheFarthestFunctionsFadeWithDistance) {
  Points centres(100, 3);
  for (int a = 0; a < 100; ++a) centres.row(a) = Eigen::RowVector3d(a, 0, 0);
  ActiveRefinement active(100, 4);
  const auto follow = [&](double x, double share = 1) {
    const Vector3d point[] = {Vector3d(x, 0, 0)};
    active.ChooseNearest(centres, point, 4, share);
  };
  const auto weight = [&](int function) { return active.Weight(active.Slot(function)); };
  follow(10.49);  // 9 .. 12 are in; 12 is at 1.51, 8, the first outside, at 2.49
  EXPECT_EQ(weight(10), 1);
  EXPECT_EQ(weight(12), 1);
  follow(10.99);  // 13 comes at 11.0: 9 is at 1.99, 13 at 2.01
  EXPECT_NEAR(weight(9), (1 - 1.99 * 1.99 / (2.01 * 2.01)) / ActiveRefinement::kBand, 1e-12);
  EXPECT_NEAR(active.Kept(active.Slot(9)), weight(9), 1e-12);
  EXPECT_EQ(active.Kept(active.Slot(10)), 1);
  const double fading = weight(9);
  follow(10.99, 0.5);
  EXPECT_EQ(weight(10), 0.5);
  EXPECT_NEAR(weight(9), fading / 2, 1e-12);  // round-off
  EXPECT_EQ(active.Kept(active.Slot(10)), 0.5);
  follow(11.0 + 1e-9);
  EXPECT_EQ(weight(13), ActiveRefinement::kMinWeight);
  follow(11.0, 0);
  EXPECT_EQ(active.used(), 0);
}

TEST(ActiveRefinement, WithoutContactAllAreReleased) {
  ActiveRefinement active(10, 4);
  const Vector3d point[] = {Vector3d::Zero()};
  const Points centres = Points::Random(10, 3);
  active.ChooseNearest(centres, point, 4);
  active.ChooseNearest(centres, {}, 4);
  for (int s = 0; s < 4; ++s) EXPECT_EQ(active.Function(s), -1);
}

TEST(ActiveRefinement, TwoContactsShareTheSlots) {
  Points centres(10, 3);
  for (int a = 0; a < 10; ++a) centres.row(a) = Eigen::RowVector3d(a, 0, 0);
  ActiveRefinement active(10, 8);
  const Vector3d points[] = {Vector3d(1.4, 0, 0), Vector3d(3.4, 0, 0)};
  active.ChooseNearest(centres, points, 4);  // 0..3 and 2..5: two are in both
  int used = 0;
  for (int s = 0; s < 8; ++s) used += active.Function(s) >= 0;
  EXPECT_EQ(used, 6);
}

}  // namespace
}  // namespace hpdm
