// Tests what the picture shows of clips on a duct.

#include "render/tissue/duct_renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "engine/base/error.h"
#include "engine/duct/duct_state.h"
#include "render/camera/picture_target.h"
#include "render/gl/egl_context.h"
#include "render/scene_renderer.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

constexpr int kDuctWidth = 320, kDuctHeight = 240;

/// A duct of 4.4 mm across that the world holds, seen from the front before a red block.
class ClippedDuct : public testing::Test {
 protected:
  void SetUp() override {
    try {
      context_ = std::make_unique<EglContext>();
    } catch (const MachineError& error) {
      GTEST_SKIP() << error.what();
    }
    OrganOptions wall;
    wall.name = "wall";
    wall.model = OrganModelType::kRigid;
    organs_.emplace_back(wall, GridBox({-0.1, 0.02, -0.1}, {0.1, 0.03, 0.1}, {4, 2, 4}));
    DuctOptions options;
    options.name = "duct";
    options.path_W.resize(2, 3);
    options.path_W << -0.015, 0, 0, 0.015, 0, 0;
    options.radius = 0.0022;
    options.wall = 0.0008;
    options.young = 1e5;
    duct_ = std::make_unique<DuctModel>(options, nullptr, nullptr);
    scene_ = SizedSnapshot(organs_, 0, true);
    scene_.ducts = {SnapshotOf(duct_->rod)};
  }

  Image Picture() {
    LaparoscopeOptions options;
    options.p_scope_W = Vector3d(0, -0.06, 0.02);
    options.p_target_W = Vector3d(0, 0, 0);
    const Laparoscope scope(options, kDuctWidth, kDuctHeight);
    SceneRenderer view({{.rest = &organs_[0].rest()}}, {}, nullptr,
                       {.occlusion = false, .shadows = false}, {}, {{.model = duct_.get()}});
    PictureTarget target(kDuctWidth, kDuctHeight, 4);
    target.Bind();
    view.Draw(scene_, scope);
    target.Resolve(scope);
    Image image;
    target.Read(&image);
    EXPECT_EQ(context_->Failure(), "");
    return image;
  }

  std::unique_ptr<EglContext> context_;
  std::vector<OrganModel> organs_;
  std::unique_ptr<DuctModel> duct_;
  SceneSnapshot scene_;
};

struct ClipPixels {
  int changed = 0, grey = 0, bright = 0;  // of the changed ones
  int left = kDuctWidth, right = 0, top = kDuctHeight, bottom = 0;
};

ClipPixels Compare(const Image& before, const Image& after) {
  ClipPixels pixels;
  for (int i = 0; i < kDuctWidth * kDuctHeight; ++i) {
    const auto at = [&](const Image& image, int channel) {
      return static_cast<int>(image.At(i % kDuctWidth, i / kDuctWidth)[channel]);
    };
    const int red = at(after, 0), green = at(after, 1), blue = at(after, 2);
    const int change = std::abs(red - at(before, 0)) + std::abs(green - at(before, 1)) +
                       std::abs(blue - at(before, 2));
    if (change < 30) continue;
    ++pixels.changed;
    if (std::max({red, green, blue}) - std::min({red, green, blue}) > 30) continue;
    ++pixels.grey;
    pixels.bright += green > 200;
    pixels.left = std::min(pixels.left, i % kDuctWidth);
    pixels.right = std::max(pixels.right, i % kDuctWidth);
    pixels.top = std::min(pixels.top, i / kDuctWidth);
    pixels.bottom = std::max(pixels.bottom, i / kDuctWidth);
  }
  return pixels;
}

TEST_F(ClippedDuct, HasAClipOfGreyMetalAcrossItThatIsWiderThanTheTube) {
  const Image open = Picture();
  scene_.ducts[0].segments[scene_.ducts[0].nodes / 2] = SegmentState::kClipped;
  const ClipPixels clip = Compare(open, Picture());
  EXPECT_GT(clip.grey, 60);
  EXPECT_GT(clip.grey, 0.3 * clip.changed);
  EXPECT_GT(clip.bottom - clip.top, 2 * (clip.right - clip.left)) << "it lies across the duct";
  scene_.ducts[0].segments[scene_.ducts[0].nodes / 2] = SegmentState::kOpen;
  EXPECT_EQ(Compare(open, Picture()).changed, 0);
}

TEST(ClipMesh, IsClosedAndEnclosesTheFlattenedTube) {
  const SurfaceMesh mesh = ClipMesh(0.0005, 0.003);
  EXPECT_TRUE(IsClosed(mesh));
  EXPECT_GT(mesh.vertices.col(1).maxCoeff(), 0.003);
  EXPECT_LT(mesh.vertices.col(1).minCoeff(), -0.003);
  EXPECT_NEAR(mesh.vertices.col(0).maxCoeff(), -mesh.vertices.col(0).minCoeff(), 1e-9);
  const auto width = mesh.vertices.col(2).maxCoeff() - mesh.vertices.col(2).minCoeff();
  EXPECT_NEAR(width, 0.0012, 1e-9);
}

}  // namespace
}  // namespace hpdm
