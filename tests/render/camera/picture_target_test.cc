#include "render/camera/picture_target.h"

#include <gtest/gtest.h>

namespace hpdm {
namespace {

TEST(PictureTarget, FitsAnyScreenCentredWithItsProportions) {
  const ScreenPlace wide = FitOnScreen(640, 480, 1000, 480);
  EXPECT_EQ(wide.width, 640);
  EXPECT_EQ(wide.height, 480);
  EXPECT_EQ(wide.x, 180);
  EXPECT_EQ(wide.y, 0);
  const ScreenPlace tall = FitOnScreen(640, 480, 320, 400);
  EXPECT_EQ(tall.width, 320);
  EXPECT_EQ(tall.height, 240);
  EXPECT_EQ(tall.x, 0);
  EXPECT_EQ(tall.y, 80);
}

}  // namespace
}  // namespace hpdm
