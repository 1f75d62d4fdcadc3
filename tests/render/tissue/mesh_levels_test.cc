#include "render/tissue/mesh_levels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/error.h"
#include "engine/mesh/collision.h"
#include "engine/mesh/mesh_facts.h"
#include "render/camera/picture_target.h"
#include "render/gl/egl_context.h"
#include "render/scene_renderer.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

const Vector3d kAxes(0.06, 0.05, 0.04);

/// 5,120 triangles of about 4 mm; with a texture by longitude and latitude: a seam down one side,
/// and a scale that both make about right at the equator.
SurfaceMesh Body(bool textured) {
  SurfaceMesh mesh = Ellipsoid(kAxes, 4);
  if (!textured) return mesh;
  mesh.texture_coordinates.resize(3 * mesh.triangles.rows(), 2);
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    double first = 0;
    for (int k = 0; k < 3; ++k) {
      const Vector3d p = Vector3d(mesh.vertices.row(mesh.triangles(t, k))).cwiseQuotient(kAxes);
      double u = std::atan2(p.y(), p.x()) / (2 * M_PI);
      if (k == 0) first = u;
      u += std::round(first - u);
      mesh.texture_coordinates.row(3 * t + k) << u, std::asin(std::clamp(p.z(), -1.0, 1.0)) / M_PI;
    }
  }
  return mesh;
}

std::vector<MeshLevel> LevelsOf(const SurfaceMesh& mesh, double metres_per_uv = 0) {
  return MakeLevels(CutSeams(mesh), mesh.vertices, metres_per_uv);
}

// Returns the largest distance of a mesh's vertices from one of its levels, m.
double FarthestOff(const MeshLevel& level, const SeamedMesh& mesh, const Points& vertices) {
  Points drawn(vertices.rows() + static_cast<Eigen::Index>(mesh.copies.size()), 3);
  drawn.topRows(vertices.rows()) = vertices;
  for (std::size_t c = 0; c < mesh.copies.size(); ++c) {
    drawn.row(vertices.rows() + static_cast<Eigen::Index>(c)) = vertices.row(mesh.copies[c]);
  }
  const SurfaceTree tree(drawn, level.triangles);
  double farthest = 0;
  for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
    farthest = std::max(farthest, tree.Closest(vertices.row(v).transpose(), 1).distance);
  }
  return farthest;
}

TEST(MeshLevels, HaveHalfAsManyTrianglesEachAndStayClosed) {
  const SurfaceMesh mesh = Body(false);
  const std::vector<MeshLevel> levels = LevelsOf(mesh);
  ASSERT_GE(levels.size(), 5u);
  EXPECT_EQ(levels[0].triangles, mesh.triangles);
  EXPECT_TRUE(levels[0].dropped.empty());
  EXPECT_EQ(levels[0].error, 0);
  const double volume = EnclosedVolume(mesh.vertices, mesh.triangles);
  for (std::size_t k = 1; k < levels.size(); ++k) {
    EXPECT_EQ(levels[k].triangles.rows(), mesh.triangles.rows() >> k);
    const SurfaceMesh level{mesh.vertices, levels[k].triangles, {}};
    EXPECT_TRUE(IsClosed(level));
    EXPECT_GT(levels[k].error, levels[k - 1].error);
    // Each level's edges are about root two as long.
    EXPECT_NEAR(levels[k].mean_edge / levels[k - 1].mean_edge, std::sqrt(2.), 0.12);
    // The lost volume is less than a shell as thick as the error.
    EXPECT_NEAR(EnclosedVolume(mesh.vertices, levels[k].triangles) / volume, 1,
                3 * levels[k].error / kAxes.minCoeff());
  }
  // The second of half as many edges an axis: sagitta of chords of 8 mm on radii about 50 mm, and
  // no more than three times that where triangles are uneven.
  EXPECT_LT(levels[2].error, 3 * 0.008 * 0.008 / 8 / 0.05);
}

TEST(MeshLevels, BoundTheErrorAtRestAndDeformed) {
  for (const bool textured : {false, true}) {
    const SurfaceMesh mesh = Body(textured);
    const SeamedMesh seamed = CutSeams(mesh);
    EXPECT_EQ(seamed.copies.empty(), !textured);
    Points dented = mesh.vertices;
    for (Eigen::Index v = 0; v < dented.rows(); ++v) {
      const double d = (dented.row(v) - Eigen::RowVector3d(0, 0, 0.04)).norm() / 0.01;
      if (d < 1) dented(v, 2) -= 0.008 * std::pow(std::cos(M_PI / 2 * d), 2);
    }
    const std::vector<MeshLevel> levels = LevelsOf(mesh);
    for (const MeshLevel& level : levels) {
      const double rounding = 1e-8;  // m, of floats
      EXPECT_LE(FarthestOff(level, seamed, mesh.vertices), level.error + rounding);
      const double deformed = DeformedError(level, seamed.copies, dented.cast<float>());
      EXPECT_LE(FarthestOff(level, seamed, dented), deformed + rounding);
      EXPECT_GE(deformed, level.error);
    }
    if (textured) continue;
    // A dent that falls between the corners is not missed.
    const MeshLevel& coarse = levels[4];
    EXPECT_GT(DeformedError(coarse, seamed.copies, dented.cast<float>()), coarse.error + 0.001);
  }
}

TEST(MeshLevels, KeepTheTextureWhereItIs) {
  const SurfaceMesh mesh = Body(true);
  const SeamedMesh seamed = CutSeams(mesh);
  const double metres_per_uv = 0.3;  // round the equator
  std::set<int> seam(seamed.copies.begin(), seamed.copies.end());
  const auto count = static_cast<int>(mesh.vertices.rows());
  for (const MeshLevel& level : LevelsOf(mesh, metres_per_uv)) {
    double drift2 = 0;
    int count_away = 0;  // from the poles, where the texture's map is singular
    for (const MeshLevel::Place& place : level.dropped) {
      EXPECT_LT(place.vertex, count);
      EXPECT_EQ(seam.count(place.vertex), 0u) << "on the seam";
      EXPECT_NEAR(place.weights[0] + place.weights[1] + place.weights[2], 1, 1e-6);
      Eigen::RowVector2f uv = seamed.texture_coordinates.row(place.vertex);
      for (int k = 0; k < 3; ++k) {
        uv -= place.weights[k] * seamed.texture_coordinates.row(place.corners[k]);
      }
      if (std::abs(mesh.vertices(place.vertex, 2)) > 0.6 * kAxes.z()) continue;
      drift2 += std::pow(metres_per_uv * uv.norm(), 2);
      ++count_away;
    }
    if (level.dropped.empty()) continue;
    drift2 /= std::max(count_away, 1);
    // The map bends little over an edge that is short beside the body.
    if (level.mean_edge < 0.012) {
      EXPECT_LT(std::sqrt(drift2), 0.15 * level.mean_edge);
    }
    EXPECT_GT(level.error, 0.5 * std::sqrt(drift2)) << "counted with the shape";
  }
}

TEST(LevelChoice, IsTheMeshNearbyAndCoarserFartherOffWithoutAlternating) {
  const std::vector<MeshLevel> levels = LevelsOf(Body(false));
  const auto at_rest = [&](int k) { return levels[static_cast<std::size_t>(k)].error; };
  const auto serves = [&](int k, double scale) {
    const MeshLevel& level = levels[static_cast<std::size_t>(k)];
    return k == 0 || (level.mean_edge * scale <= LevelChoice::kMaxEdge &&
                      level.error * scale <= LevelChoice::kMaxError);
  };
  int level = 0, changes = 0;
  EXPECT_EQ(LevelChoice::After(3, levels, 1e4, at_rest), 0) << "straight to what serves";
  for (double scale = 1e4; scale > 10; scale *= 0.99) {  // px a metre: away
    const int next = LevelChoice::After(level, levels, scale, at_rest);
    EXPECT_GE(next, level);
    EXPECT_TRUE(serves(next, scale));
    EXPECT_EQ(LevelChoice::After(next, levels, scale, at_rest), next);
    // Trembling by a twentieth changes nothing more.
    EXPECT_EQ(LevelChoice::After(next, levels, 1.05 * scale, at_rest), next);
    changes += next != level;
    level = next;
  }
  EXPECT_EQ(level, static_cast<int>(levels.size()) - 1);
  EXPECT_GE(changes, 4);
  // A level that the organ's deformation spoils is not drawn.
  EXPECT_EQ(LevelChoice::After(level, levels, 10, [](int) { return 1.0; }), 0);
}

TEST(LevelChoice, NoLineInABoxIsDrawnLongerThanTheScopesBound) {
  std::mt19937 random(7);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (random() / 4294967296.0);
  };
  for (const double distortion : {0.0, -0.2, 0.2}) {
    LaparoscopeOptions options;
    options.p_scope_W = Vector3d(0.02, -0.2, 0.1);
    options.distortion = distortion;
    const Laparoscope scope(options, 640, 480);
    const Vector3d low(-0.1, -0.05, -0.06), high(0.08, 0.09, 0.05);
    const double most = scope.MostPixelsPerMetre(low, high);
    double largest = 0;
    for (int trial = 0; trial < 20'000; ++trial) {
      Vector3d p, way;
      for (int d = 0; d < 3; ++d) {
        p[d] = uniform(low[d], high[d]);
        way[d] = uniform(-1, 1);
      }
      way *= 1e-6 / way.norm();
      const Vector3d a = scope.Project(p), b = scope.Project(p + way);
      if ((a.head<2>() - Eigen::Vector2d(320, 240)).norm() > scope.circle_radius_px()) continue;
      largest = std::max(largest, (b - a).head<2>().norm() / 1e-6);
    }
    EXPECT_LT(largest, (1 + 1e-5) * most);
    EXPECT_GT(largest, 0.4 * most) << "the bound is of use";
    EXPECT_TRUE(scope.MaySee(low, high));
    EXPECT_FALSE(scope.MaySee(Vector3d(-0.1, -0.5, 0), Vector3d(0.1, -0.4, 0.2))) << "behind";
    EXPECT_FALSE(scope.MaySee(Vector3d(0.3, -0.2, 0), Vector3d(0.4, -0.1, 0.2))) << "beside";
    EXPECT_TRUE(scope.MaySee(Vector3d(-1, -1, -1), Vector3d(1, 1, 1))) << "all around";
    // The scope is in it.
    EXPECT_TRUE(std::isinf(
        scope.MostPixelsPerMetre(Vector3d(-0.1, -0.3, -0.06), Vector3d(0.08, 0.09, 0.2))));
  }
}

class LevelPicturesTest : public testing::Test {
 protected:
  static constexpr int kWidth = 320, kHeight = 240;

  void SetUp() override {
    try {
      context_ = std::make_unique<EglContext>();
    } catch (const MachineError& error) {
      GTEST_SKIP() << error.what();
    }
    target_.emplace(kWidth, kHeight, 4);
    snapshot_.organs.resize(1);
    snapshot_.organs[0].vertices = mesh_.vertices.cast<float>();
  }
  std::unique_ptr<SceneRenderer> View(bool levels) const {
    return std::make_unique<SceneRenderer>(std::vector<OrganVisual>{{.rest = &mesh_}},
                                           std::vector<InstrumentVisual>{}, nullptr,
                                           SceneRendererOptions{.levels = levels});
  }
  Image Draw(SceneRenderer* view, double distance) {
    LaparoscopeOptions options;
    options.p_scope_W = distance * Vector3d(0.3, -0.8, 0.5).normalized();
    const Laparoscope scope(options, kWidth, kHeight);
    Image image;
    target_->Bind();
    view->Draw(snapshot_, scope);
    target_->Resolve(scope);
    target_->Read(&image);
    EXPECT_EQ(context_->Failure(), "");
    return image;
  }
  // Mean and largest difference of two pictures over the pixels that are the organ's, of 255.
  struct Difference {
    double mean = 0;
    int largest = 0;
    int pixels = 0;
  };
  Difference Between(const Image& a, const Image& b, double distance) const {
    // The organ's outline is within 1.3 times its largest axis.
    const double radius = 0.06 / distance * kHeight / 2 / std::tan(0.6);
    Difference difference;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        if (std::hypot(x - kWidth / 2, y - kHeight / 2) > radius) continue;
        ++difference.pixels;
        for (int c = 0; c < 3; ++c) {
          const int d = std::abs(a.At(x, y)[c] - b.At(x, y)[c]);
          difference.mean += d / 3.0;
          difference.largest = std::max(difference.largest, d);
        }
      }
    }
    difference.mean /= std::max(difference.pixels, 1);
    return difference;
  }

  const SurfaceMesh mesh_ = Body(false);
  std::unique_ptr<EglContext> context_;
  std::optional<PictureTarget> target_;
  SceneSnapshot snapshot_;
};

TEST_F(LevelPicturesTest, NearbyThePictureIsTheSame) {
  const auto with = View(true), without = View(false);
  for (const double distance : {0.1, 0.15, 0.2}) {
    EXPECT_EQ(Draw(with.get(), distance).rgb, Draw(without.get(), distance).rgb) << distance;
  }
}

// One comes from afar and one from nearby: where the coming one has not yet gone to the finer level
// that the going one still draws, both are at the border of the same switch.
TEST_F(LevelPicturesTest, ASwitchIsInvisible) {
  const auto coming = View(true), going = View(true), without = View(false);
  // The cavity's wall stands where the first picture had it.
  for (SceneRenderer* view : {coming.get(), going.get(), without.get()}) Draw(view, 1.9);
  std::vector<std::pair<double, Image>> away;
  for (double distance = 0.2; distance < 1.5; distance *= 1.03) {
    away.emplace_back(distance, Draw(going.get(), distance));
  }
  int borders = 0;
  for (auto at = away.rbegin(); at != away.rend(); ++at) {
    const auto& [distance, before] = *at;
    const Image after = Draw(coming.get(), distance);
    const Difference change = Between(before, after, distance);
    borders += change.largest > 0;
    // Levels of 255 over the organ's pixels. An eye notices about 2 in a flat field. Below 500
    // pixels (25 across) the outline's pixels dominate.
    const double most = change.pixels > 500 ? 0.5 : 1.5;
    EXPECT_LT(change.mean, most) << distance;
    EXPECT_LT(Between(after, Draw(without.get(), distance), distance).mean, 1.5 * most) << distance;
  }
  EXPECT_GE(borders, 3) << "there are switches to see";
}

}  // namespace
}  // namespace hpdm
