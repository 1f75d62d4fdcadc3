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
  const auto red = [y](const Image& image, double x) {
    return static_cast<int>(image.At(static_cast<int>(x), y)[0]);
  };
  // 2 mm beside the crease, a quarter of the radius of the surroundings.
  const double near_crease = scope.Project(Vector3d(0.002, -0.0087, 0.1)).x();
  EXPECT_LT(red(shaded, near_crease), 0.9 * red(open, near_crease));
  // In front of an axis and towards the outer side the surface is convex: the same bytes.
  for (const double x : {0.02, 0.03, 0.035}) {
    const double on_surface = -std::sqrt(0.0004 - (x - 0.02) * (x - 0.02));
    const double at = scope.Project(Vector3d(x, on_surface, 0.1)).x();
    EXPECT_EQ(red(shaded, at), red(open, at)) << x;
  }
}

}  // namespace
}  // namespace hpdm
