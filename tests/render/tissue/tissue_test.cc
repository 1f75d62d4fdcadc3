// Tissue in the picture: its fine relief and the shade between organs.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "engine/base/error.h"
#include "render/camera/picture_target.h"
#include "render/gl/egl_context.h"
#include "render/instrument/capsule_mesh.h"
#include "render/scene_renderer.h"
#include "render/tissue/tissue_detail.h"

namespace hpdm {
namespace {

TEST(TissueDetail, TilesWithoutASeamAndIsFlatOnAverage) {
  const Texels map = TissueDetail();
  const auto at = [&](int x, int y, int channel) {
    return static_cast<int>(map.rgba[static_cast<std::size_t>(4 * (y * map.width + x) + channel)]);
  };
  int across_seam = 0, inside = 0;
  double mean_u = 0, mean_v = 0;
  for (int i = 0; i < map.width; ++i) {
    across_seam = std::max({across_seam, std::abs(at(0, i, 3) - at(map.width - 1, i, 3)),
                            std::abs(at(i, 0, 3) - at(i, map.height - 1, 3))});
    for (int x = 1; x < map.width; ++x) {
      inside = std::max(inside, std::abs(at(x, i, 3) - at(x - 1, i, 3)));
      mean_u += at(x, i, 0) - 127.5;
      mean_v += at(x, i, 1) - 127.5;
    }
  }
  EXPECT_LE(across_seam, inside);
  // The slope of a periodic height has no mean; bytes round it by less than half a step.
  const double count = double(map.width) * map.height;
  EXPECT_LT(std::abs(mean_u / count), 0.6);
  EXPECT_LT(std::abs(mean_v / count), 0.6);
}

TEST(TissueDetail, CoordinatesOfABareMeshAreMetresOnIt) {
  const SurfaceMesh capsule = WithCoordinates(CapsuleMesh(0.02, 0.02, 0.2));
  ASSERT_EQ(capsule.texture_coordinates.rows(), 3 * capsule.triangles.rows());
  // The projection along the nearest axis shortens an edge to 1 / sqrt(3) of it at worst.
  EXPECT_GE(MetresPerCoordinate(capsule), 1);
  EXPECT_LE(MetresPerCoordinate(capsule), std::sqrt(std::sqrt(3.0)));
  SurfaceMesh in_tiles = capsule;
  in_tiles.texture_coordinates *= 25;
  EXPECT_NEAR(MetresPerCoordinate(in_tiles), MetresPerCoordinate(capsule) / 25, 1e-12);
}

TEST(Occlusion, DarkensTheCreaseBetweenTwoOrgansAndNothingElse) {
  std::unique_ptr<EglContext> context;
  try {
    context = std::make_unique<EglContext>();
  } catch (const MachineError& error) {
    GTEST_SKIP() << error.what();
  }
  // Two upright cylinders of 20 mm radius that touch in the picture's middle.
  SurfaceMesh left = CapsuleMesh(0.02, 0.02, 0.2, 64), right = left;
  left.vertices.col(0).array() -= 0.02;
  right.vertices.col(0).array() += 0.02;
  SceneSnapshot snapshot;
  snapshot.organs.resize(2);
  snapshot.organs[0].vertices = left.vertices.cast<float>();
  snapshot.organs[1].vertices = right.vertices.cast<float>();
  LaparoscopeOptions options;
  options.p_scope_W = Vector3d(0, -0.15, 0.1);
  options.p_target_W = Vector3d(0, 0, 0.1);
  constexpr int kWidth = 320, kHeight = 240;
  const Laparoscope scope(options, kWidth, kHeight);
  const auto picture = [&](bool occlusion) {
    PictureTarget target(kWidth, kHeight, 4);
    SceneRenderer view({{.rest = &left}, {.rest = &right}}, {}, nullptr, {.occlusion = occlusion});
    target.Bind();
    view.Draw(snapshot, scope);
    target.Resolve(scope);
    Image image;
    target.Read(&image);
    return image;
  };
  const Image open = picture(false), shaded = picture(true);
  ASSERT_EQ(context->Failure(), "");
  const int y = kHeight / 2;
  const auto red = [](const Image& image, double x) {
    return static_cast<int>(image.At(static_cast<int>(x), y)[0]);
  };
  // 2 mm beside the crease, a quarter of the radius of the surroundings.
  const double near_crease = scope.Project(Vector3d(0.002, -0.0087, 0.1)).x();
  EXPECT_LT(red(shaded, near_crease), 0.9 * red(open, near_crease));
  // The surface is convex in front of an axis and towards the outer side: the bytes stay the same.
  for (const double x : {0.02, 0.03, 0.035}) {
    const double on_surface = -std::sqrt(0.0004 - (x - 0.02) * (x - 0.02));
    const double at = scope.Project(Vector3d(x, on_surface, 0.1)).x();
    EXPECT_EQ(red(shaded, at), red(open, at)) << x;
  }
}

// Returns a thick capsule along x below the lens; its top is at z = 0. The picture's up is y.
SurfaceMesh CapsuleBelowTheLens() {
  SurfaceMesh tissue = CapsuleMesh(0.2, 0.2, 0.8, 64);
  const Points along_z = tissue.vertices;
  tissue.vertices.col(0) = along_z.col(2).array() - 0.3;
  tissue.vertices.col(2) = -along_z.col(0).array() - 0.2;
  return tissue;
}

TEST(InstrumentShadow, FallsBelowTheTipTheFartherTheHigherTheTipIsAndJoinsItAtTheTouch) {
  std::unique_ptr<EglContext> context;
  try {
    context = std::make_unique<EglContext>();
  } catch (const MachineError& error) {
    GTEST_SKIP() << error.what();
  }
  const SurfaceMesh tissue = CapsuleBelowTheLens();
  SceneSnapshot snapshot;
  snapshot.organs.resize(1);
  snapshot.organs[0].vertices = tissue.vertices.cast<float>();
  snapshot.tool_count = 1;
  LaparoscopeOptions options;
  options.p_scope_W = Vector3d(0, 0, 0.15);
  options.p_target_W = Vector3d::Zero();
  constexpr int kWidth = 320, kHeight = 240;
  const Laparoscope scope(options, kWidth, kHeight);
  const Vector3d up_W = scope.X_WC().linear().col(1);
  PictureTarget target(kWidth, kHeight, 4);
  InstrumentVisual probe;
  probe.geometry.tip_radius = probe.geometry.shaft_radius = 0.0025;
  SceneRenderer with({{.rest = &tissue}}, {probe}), without({{.rest = &tissue}}, {});
  const auto picture = [&](SceneRenderer* view) {
    target.Bind();
    view->Draw(snapshot, scope);
    target.Resolve(scope);
    Image image;
    target.Read(&image);
    return image;
  };
  const Image open = picture(&without);
  // Returns the distance of the darkest place from the tip, down in the picture, m on the tissue.
  const auto shadow_below = [&](double height) {
    snapshot.tools[0].X_WT.setIdentity();
    snapshot.tools[0].X_WT.translation() = Vector3d(0, 0, height);
    // The shaft comes from above in the picture, so it hides no tissue below the tip.
    snapshot.tools[0].X_WT.linear() =
        Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), 0.8 * up_W + Vector3d(0, 0, 0.6))
            .toRotationMatrix();
    const Image shaded = picture(&with);
    double darkest = 1, at = 0;
    for (double below = 0.004; below < 0.035; below += 0.0005) {
      const Vector3d pixel = scope.Project(-below * up_W);
      const int x = static_cast<int>(pixel.x()), y = static_cast<int>(pixel.y());
      const double ratio = double(shaded.At(x, y)[0]) / open.At(x, y)[0];
      if (ratio < darkest - 0.01) darkest = ratio, at = below;
    }
    EXPECT_LT(darkest, 0.9) << height;
    return at;
  };
  const double touching = shadow_below(0.0025), low = shadow_below(0.02);
  const double high = shadow_below(0.035);
  ASSERT_EQ(context->Failure(), "");
  EXPECT_LT(touching, 0.006);
  // Similar triangles give the distance h 0.05 / (0.15 - h). Tip and penumbra are 3 mm wide.
  EXPECT_NEAR(low, 0.0077, 0.003);
  EXPECT_NEAR(high, 0.0152, 0.003);
}

}  // namespace
}  // namespace hpdm
