#include "engine/contact/surface_kernel.h"

#include <gtest/gtest.h>

#include "engine/base/error.h"
#include "tests/support/mesh_shapes.h"

namespace hpdm {
namespace {

double Sum(const std::vector<SurfaceSample>& samples) {
  double sum = 0;
  for (const SurfaceSample& sample : samples) sum += sample.weight;
  return sum;
}

/// Weighted mean of the squared distance to `p`.
double MeanSquaredDistance(const std::vector<SurfaceSample>& samples, const SurfaceMesh& mesh,
                           const Vector3d& p) {
  double sum = 0;
  for (const SurfaceSample& sample : samples) {
    sum += sample.weight * (AtSample(sample, mesh.triangles, mesh.vertices) - p).squaredNorm();
  }
  return sum;
}

TEST(SurfaceKernel, WeightsFollowTheKernelInsideOneTriangle) {
  const SurfaceMesh box = MakeBox(Vector3d(-1, -1, -1), Vector3d(1, 1, 1));
  const Vector3d point(0.3, -0.2, 1);
  constexpr double kRadius = 0.05;  // the top's triangles have sides of 2 and more
  const std::vector<SurfaceSample> samples = SurfaceKernel(box, point, kRadius);
  EXPECT_NEAR(Sum(samples), 1, 1e-12);
  // int cos(pi d / 2R) d^3 / int cos(pi d / 2R) d over d < R, times 1 / R^2, by hand with
  // s = pi d / 2R: (pi^3/8 - 3 pi + 6) / (pi/2 - 1) * 4 / pi^2.
  constexpr double kPi = std::numbers::pi;
  const double expected =
      (kPi * kPi * kPi / 8 - 3 * kPi + 6) / (kPi / 2 - 1) * 4 / (kPi * kPi) * kRadius * kRadius;
  // Parts of R / 8 place the rim's kink to about 1 %.
  EXPECT_NEAR(MeanSquaredDistance(samples, box, point), expected, 0.01 * expected);
  for (const SurfaceSample& sample : samples) {
    EXPECT_NEAR(AtSample(sample, box.triangles, box.vertices).z(), 1, 1e-12);
    EXPECT_NEAR(sample.barycentric.sum(), 1, 1e-12);
    EXPECT_GE(sample.barycentric.minCoeff(), 0);
  }
}

TEST(SurfaceKernel, TheOtherSideOfAThinWallTakesNoPart) {
  const SurfaceMesh plate = MakeBox(Vector3d(-1, -1, 0), Vector3d(1, 1, 0.01));
  for (const SurfaceSample& sample : SurfaceKernel(plate, Vector3d(0, 0, 0.01), 0.1)) {
    EXPECT_NEAR(AtSample(sample, plate.triangles, plate.vertices).z(), 0.01, 1e-12);
  }
}

TEST(SurfaceKernel, TriangulationDoesNotMatter) {
  // The same flat top, once as two triangles and once as many: the spread differs by no more than
  // the samples' own error.
  const SurfaceMesh coarse = MakeBox(Vector3d(0, 0, -1), Vector3d(1, 1, 0));
  constexpr int kCells = 23;
  std::vector<Vector3d> vertices;
  std::vector<std::array<int, 3>> triangles;
  for (int j = 0; j <= kCells; ++j) {
    for (int i = 0; i <= kCells; ++i) {
      vertices.emplace_back(static_cast<double>(i) / kCells, static_cast<double>(j) / kCells, 0);
      if (i == kCells || j == kCells) continue;
      const int a = i + (kCells + 1) * j, b = a + 1, c = a + kCells + 1, d = c + 1;
      triangles.insert(triangles.end(), {{a, b, d}, {a, d, c}});
    }
  }
  const SurfaceMesh fine = MakeMesh(vertices, triangles);
  const Vector3d point(0.41, 0.53, 0);
  const double spread = MeanSquaredDistance(SurfaceKernel(coarse, point, 0.2), coarse, point);
  EXPECT_NEAR(MeanSquaredDistance(SurfaceKernel(fine, point, 0.2), fine, point), spread,
              0.01 * spread);
}

TEST(SurfaceKernel, RoundOffDoesNotChooseTheSamples) {
  // Equilateral triangles and a point on an edge of a box: every side and every right angle ties,
  // and scale and place change the rounding of each.
  const double kHeight = std::sqrt(3) / 2;
  const SurfaceMesh tile = MakeMesh({{0, 0, 0}, {1, 0, 0}, {0.5, kHeight, 0}, {1.5, kHeight, 0}},
                                    {{0, 1, 2}, {1, 3, 2}});
  const SurfaceMesh box = MakeBox(Vector3d::Zero(), Vector3d::Ones());
  for (const auto& [rest, point, radius] :
       {std::tuple(tile, Vector3d(0.7, 0.4, 0), 0.25), std::tuple(box, Vector3d(0.4, 0, 1), 0.5)}) {
    const std::vector<SurfaceSample> expected = SurfaceKernel(rest, point, radius);
    for (const double scale : {1e-3, 0.37, 3.0, 1e3}) {
      SurfaceMesh mesh = rest;
      const Vector3d shift = scale * Vector3d(0.1, -0.7, 0.3);
      mesh.vertices = (scale * mesh.vertices).rowwise() + shift.transpose();
      const std::vector<SurfaceSample> samples =
          SurfaceKernel(mesh, scale * point + shift, scale * radius);
      ASSERT_EQ(samples.size(), expected.size());
      for (std::size_t s = 0; s < samples.size(); ++s) {
        EXPECT_EQ(samples[s].triangle, expected[s].triangle);
        EXPECT_EQ(samples[s].barycentric, expected[s].barycentric);  // halves: exact
        EXPECT_NEAR(samples[s].weight, expected[s].weight, 1e-12);   // round-off
      }
    }
  }
}

TEST(SurfaceKernel, NamesTheNearestPointWhenTheLoadMissesTheSurface) {
  try {
    SurfaceKernel(MakeBox(Vector3d::Zero(), Vector3d::Ones()), Vector3d(0.5, 0.5, 2), 0.1);
    FAIL() << "a load without a surface must be refused";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("[0.5 0.5   1]"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace hpdm
