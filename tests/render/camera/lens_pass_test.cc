#include "render/camera/lens_pass.h"

#include <epoxy/gl.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "engine/base/error.h"
#include "render/camera/laparoscope.h"
#include "render/camera/picture_target.h"
#include "render/gl/egl_context.h"
#include "render/scene_renderer.h"

namespace hpdm {
namespace {

constexpr int kWidth = 320, kHeight = 240;

class LensPassTest : public testing::Test {
 protected:
  void SetUp() override {
    try {
      context_ = std::make_unique<EglContext>();
    } catch (const MachineError& error) {
      GTEST_SKIP() << error.what();
    }
  }

  static Laparoscope Scope(double distortion) {
    LaparoscopeOptions options;
    options.distortion = distortion;
    return {options, kWidth, kHeight};
  }

  /// Passes a picture that is white within `bright_px` of its middle and grey elsewhere.
  static Image Disc(double bright_px, const Laparoscope& scope, int samples) {
    PictureTarget target(kWidth, kHeight, samples);
    target.Bind();
    glClearColor(0.2f, 0.2f, 0.2f, 1);
    glClear(GL_COLOR_BUFFER_BIT);
    glClearColor(1, 1, 1, 1);
    glEnable(GL_SCISSOR_TEST);
    for (int y = 0; y < kHeight; ++y) {
      const double half =
          std::sqrt(std::max(0.0, bright_px * bright_px - std::pow(y + 0.5 - 0.5 * kHeight, 2)));
      const int first = static_cast<int>(std::lround(0.5 * kWidth - half));
      glScissor(first, y, kWidth - 2 * first, 1);
      if (half > 0) glClear(GL_COLOR_BUFFER_BIT);
    }
    glDisable(GL_SCISSOR_TEST);
    glClearColor(0, 0, 0, 0);
    target.Resolve(scope);
    Image image;
    target.Read(&image);
    return image;
  }

  std::unique_ptr<EglContext> context_;
};

TEST_F(LensPassTest, EveryProgramOfThePictureCompilesAndLinks) {
  const Image picture{2, 2, std::vector<std::uint8_t>(12, 128)};
  for (const Image* background : {static_cast<const Image*>(nullptr), &picture}) {
    EXPECT_NO_THROW(SceneRenderer({}, {}, background));
  }
  EXPECT_NO_THROW(LensPass{LensPass::Edges::kAsDrawn});
  EXPECT_NO_THROW(LensPass{LensPass::Edges::kSmoothed});
  EXPECT_EQ(context_->Failure(), "");
}

TEST_F(LensPassTest, ADiscGrowsAndShrinksToWhereTheLensPutsIt) {
  for (const double distortion : {-0.3, -0.1, 0.15, 0.3}) {
    const Laparoscope scope = Scope(distortion);
    for (const double fraction : {0.2, 0.5, 0.8}) {
      const double drawn_px = fraction * scope.circle_radius_px();
      const double seen_px =
          scope.Distorted(drawn_px / scope.focal_length_px()) * scope.focal_length_px();
      const Image image = Disc(drawn_px, scope, 4);
      // Along the middle row: the white part of a pixel that the edge cuts counts in part.
      double diameter = 0;
      for (int x = 0; x < kWidth; ++x) {
        diameter += std::clamp((image.At(x, kHeight / 2)[0] / 255.0 - 0.2) / 0.8, 0.0, 1.0);
      }
      // The disc is drawn in whole pixels, half a pixel on either side, magnified up to 1 / 0.7.
      EXPECT_NEAR(diameter, 2 * seen_px, 1.5) << distortion << ", " << fraction;
    }
  }
}

TEST_F(LensPassTest, WithoutDistortionSamplesArriveAsTheyWereDrawn) {
  const Image image = Disc(50, Scope(0), 4);
  int between = 0;
  for (const std::uint8_t byte : image.rgb) between += byte != 51 && byte != 255;
  EXPECT_EQ(between, 0);
}

TEST_F(LensPassTest, OneSampleAPixelIsBlendedOnEdgesAlone) {
  const Laparoscope scope = Scope(0);
  const Image image = Disc(50, scope, 1);
  int between = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const double r = std::hypot(x + 0.5 - 0.5 * kWidth, y + 0.5 - 0.5 * kHeight);
      const int value = image.At(x, y)[0];
      if (std::abs(r - 50) > 3) {
        // 2 % inside and 3 % outside of the circle's edge: the soft edge, to which the pass draws.
        if (r < 0.98 * scope.circle_radius_px()) {
          ASSERT_EQ(value, r < 50 ? 255 : 51);
        } else if (r > 1.03 * scope.circle_radius_px()) {
          ASSERT_EQ(value, 0);
        }
      } else {
        between += value != 51 && value != 255;
      }
    }
  }
  // Most of the 314 pixels around the disc are stairs.
  EXPECT_GT(between, 150);
}

}  // namespace
}  // namespace hpdm
