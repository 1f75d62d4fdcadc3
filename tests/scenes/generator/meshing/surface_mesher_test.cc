#include "scenes/generator/meshing/surface_mesher.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "engine/mesh/quadric.h"
#include "scenes/generator/meshing/editable_mesh.h"
#include "scenes/generator/meshing/marching_tetrahedra.h"
#include "scenes/generator/meshing/mesh_decimation.h"
#include "scenes/generator/meshing/obj_writer.h"
#include "tests/support/mesh_checks.h"

namespace hpdm {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRadius = 0.04;

Ellipsoid Ball() { return {Vector3d(0.01, -0.02, 0.005), Vector3d::Constant(kRadius)}; }

SweptBall Tube() {
  return SweptBall({{Vector3d(0, 0, 0), 0.02},
                    {Vector3d(0.03, 0.01, 0), 0.016},
                    {Vector3d(0.06, 0.03, 0.01), 0.012},
                    {Vector3d(0.08, 0.06, 0.01), 0.012}});
}

/// A box's worth of seeded points in the bounds of a shape.
std::vector<Vector3d> PointsAround(const ImplicitShape& shape, int count) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  const Bounds box = shape.bounds();
  std::vector<Vector3d> points;
  for (int i = 0; i < count; ++i) {
    const Vector3d share(unit(random), unit(random), unit(random));
    points.push_back(box.min + share.cwiseProduct(box.max - box.min));
  }
  return points;
}

void ExpectGradientIsTheDerivative(const ImplicitShape& shape) {
  constexpr double kStep = 1e-6;
  for (const Vector3d& p : PointsAround(shape, 500)) {
    const FieldSample field = shape.Sample(p);
    if (std::abs(field.value) > 0.01) continue;  // Only the surroundings of the surface count.
    for (int k = 0; k < 3; ++k) {
      const Vector3d step = kStep * Vector3d::Unit(k);
      const double difference =
          (shape.Sample(p + step).value - shape.Sample(p - step).value) / (2 * kStep);
      // Central differences: step^2 / 6 times third derivatives below 1 / (2 mm)^2, and round-off
      // of 1e-17 m over the step. Rounded joins have a second derivative that jumps, which costs
      // step / (2 x rounding) < 2e-4.
      EXPECT_NEAR(field.gradient[k], difference, 3e-4) << p.transpose();
    }
  }
}

TEST(ImplicitShapes, GradientsAreTheFieldsDerivatives) {
  ExpectGradientIsTheDerivative(
      Ellipsoid(Vector3d(0.01, 0, 0), Vector3d(0.05, 0.03, 0.02), Vector3d(1, 1, 0)));
  ExpectGradientIsTheDerivative(Tube());
  ExpectGradientIsTheDerivative(*LiverShape());
  ExpectGradientIsTheDerivative(*StomachShape());
  ExpectGradientIsTheDerivative(*GallbladderShape());
}

TEST(ImplicitShapes, SweptBallFieldIsATrueDistance) {
  const SweptBall tube = Tube();
  for (const Vector3d& p : PointsAround(tube, 300)) {
    const FieldSample field = tube.Sample(p);
    if (std::abs(field.value) > 0.01) continue;
    // Unit length follows from minimising over all balls; only round-off remains.
    EXPECT_NEAR(field.gradient.norm(), 1, 1e-12);
    // Hence one Newton step reaches the surface, and its length is the distance.
    const Vector3d foot = ProjectToLevel(tube, p, 0);
    EXPECT_NEAR((foot - p).norm(), std::abs(field.value), 1e-9);
  }
}

TEST(ImplicitShapes, SweptBallReachesFromTheFirstNodeToTheLast) {
  const SweptBall tube = Tube();
  // The end balls bound the tube along its own direction there: 2 cm behind the first node.
  const Vector3d back = -Vector3d(0.03, 0.01, 0).normalized();
  EXPECT_NEAR(tube.Sample(0.02 * back).value, 0, 1e-9);
  EXPECT_NEAR(tube.Sample(Vector3d(0.08, 0.06, 0.01)).value, -0.012, 1e-9);
}

TEST(ImplicitShapes, ProjectionEndsOnTheLevel) {
  const auto liver = LiverShape();
  for (const Vector3d& p : PointsAround(*liver, 300)) {
    if (std::abs(liver->Sample(p).value) > 0.01) continue;
    // The projection's own tolerance is 1e-10 m.
    EXPECT_NEAR(liver->Sample(ProjectToLevel(*liver, p, 1e-3)).value, 1e-3, 2e-10);
  }
}

TEST(ImplicitShapes, NearestSurfacePointIsNearestWhereTheFieldFallsShort) {
  const auto stomach = StomachShape();
  const SurfaceMesh surface = MarchTetrahedra(*stomach, 0, 3e-3);
  int checked = 0;
  for (const Vector3d& p : PointsAround(*stomach, 2000)) {
    const double value = stomach->Sample(p).value;
    if (value > -4e-3 || value < -6e-3) continue;
    const Vector3d foot = NearestSurfacePoint(*stomach, p);
    EXPECT_NEAR(stomach->Sample(foot).value, 0, 1e-9);
    // The surface's own triangulation: chords of 3 mm on rounds of 12 mm or more.
    EXPECT_NEAR((p - foot).norm(), DistanceToMesh(p, surface), 2e-4);
    ++checked;
  }
  EXPECT_GT(checked, 20);
}

TEST(MarchingTetrahedra, SurfaceIsClosedOutwardAndOfTheRightVolume) {
  const SurfaceMesh mesh = MarchTetrahedra(Ball(), 0, 4e-3);
  EXPECT_EQ(EdgeDefects(mesh), 0);
  EXPECT_EQ(EulerCharacteristic(mesh), 2);
  // Chords of the grid's length 4 mm on a ball of 40 mm lose about 3 (4 / 40)^2 / 4 < 1 %.
  EXPECT_NEAR(EnclosedVolume(mesh.vertices, mesh.triangles) / (4 * kPi / 3 * std::pow(kRadius, 3)),
              1, 0.01);
}

TEST(MarchingTetrahedra, RefusesAnEmptyLevelAndASurfaceOutsideTheBounds) {
  EXPECT_THROW(MarchTetrahedra(Ball(), -1, 4e-3), InputError);
  EXPECT_THROW(MarchTetrahedra(Ball(), 0.02, 4e-3), InputError);
}

TEST(EditableMesh, RandomOperationsKeepTheSurfaceClosedAndOriented) {
  EditableMesh mesh(MarchTetrahedra(Ball(), 0, 1.2e-2));
  std::mt19937 random(7);
  int flips = 0, collapses = 0, splits = 0;
  for (int i = 0; i < 3000; ++i) {
    const int t = static_cast<int>(random() % mesh.triangle_capacity()), k = random() % 3;
    if (!mesh.IsTriangle(t)) continue;
    const int a = mesh.corners(t)[k], b = mesh.corners(t)[(k + 1) % 3];
    const Vector3d middle = 0.5 * (mesh.position(a) + mesh.position(b));
    const int choice = random() % 3, before = mesh.triangle_count();
    if (choice == 0 && mesh.CanFlip(a, b)) {
      mesh.Flip(a, b);
      ++flips;
      EXPECT_EQ(mesh.triangle_count(), before);
    } else if (choice == 1 && mesh.CanCollapse(a, b)) {
      mesh.Collapse(a, b, middle);
      ++collapses;
      EXPECT_EQ(mesh.triangle_count(), before - 2);
    } else if (choice == 2) {
      mesh.Split(a, b, middle);
      ++splits;
      EXPECT_EQ(mesh.triangle_count(), before + 2);
    }
  }
  EXPECT_GT(std::min({flips, collapses, splits}), 100);
  const SurfaceMesh result = mesh.Compact();
  EXPECT_EQ(EdgeDefects(result), 0);
  EXPECT_EQ(EulerCharacteristic(result), 2);
}

TEST(EditableMesh, ATetrahedronCannotBeReduced) {
  SurfaceMesh tetrahedron;
  tetrahedron.vertices.resize(4, 3);
  tetrahedron.vertices << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  tetrahedron.triangles.resize(4, 3);
  tetrahedron.triangles << 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3;
  const EditableMesh mesh(tetrahedron);
  EXPECT_FALSE(mesh.CanCollapse(0, 1));
  EXPECT_FALSE(mesh.CanFlip(0, 1));
}

TEST(Quadric, MinimiserFindsTheCornerOfThreePlanes) {
  const Vector3d corner(0.3, -0.2, 0.5);
  Quadric planes;
  for (int k = 0; k < 3; ++k) planes.AddPlane(Vector3d::Unit(k), corner, 2);
  EXPECT_NEAR(planes.Error(corner), 0, 1e-15);
  EXPECT_NEAR(planes.Error(corner + Vector3d(0.1, 0, 0)), 2 * 0.01, 1e-15);
  // The pull of 1e-9 displaces it by 3e-9 of the anchor's distance (weights: 6 in all, 2 a plane).
  EXPECT_LT((planes.Minimiser(Vector3d::Zero(), 1e-9) - corner).norm(), 1e-8);
}

TEST(Quadric, MinimiserStaysAtTheAnchorWherePlanesLeaveItFree) {
  Quadric plane;
  plane.AddPlane(Vector3d::UnitZ(), Vector3d(0, 0, 1), 3);
  const Vector3d best = plane.Minimiser(Vector3d(4, 5, 0), 1e-6);
  EXPECT_NEAR(best.x(), 4, 1e-9);
  EXPECT_NEAR(best.y(), 5, 1e-9);
  EXPECT_NEAR(best.z(), 1, 2e-6);  // The pull's share.
}

TEST(SurfaceMesher, CountIsExactVolumeIsTheShapesAndTrianglesAreWellShaped) {
  const Ellipsoid ball = Ball();
  for (const int count : {60, 274, 1000}) {
    SurfaceMesherOptions options;
    options.triangle_count = count;
    const SurfaceMesh mesh = MeshImplicitSurface(ball, options);
    EXPECT_EQ(mesh.triangles.rows(), count);
    EXPECT_EQ(EdgeDefects(mesh), 0);
    EXPECT_EQ(SelfIntersections(mesh), 0);
    // The reference volume is extrapolated from 8,000 triangles: far below 1e-4.
    EXPECT_NEAR(EnclosedVolume(mesh.vertices, mesh.triangles), 4 * kPi / 3 * std::pow(kRadius, 3),
                1e-4 * 4 * kPi / 3 * std::pow(kRadius, 3));
    // An irregular mesh of a ball has corners of valence 5 to 7, whose angles are 51 to 72 degrees.
    EXPECT_GT(SmallestAngles(mesh)[0], 25);
    // All vertices at one distance: the level that conserves the volume.
    const double level = ball.Sample(Vector3d(mesh.vertices.row(0))).value;
    for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
      EXPECT_NEAR(ball.Sample(Vector3d(mesh.vertices.row(v))).value, level, 1e-9);
    }
  }
}

TEST(SurfaceMesher, WritesTheSameBytesOnEveryRun) {
  SurfaceMesherOptions options;
  options.triangle_count = 200;
  EXPECT_EQ(ObjText(MeshImplicitSurface(Tube(), options), "tube"),
            ObjText(MeshImplicitSurface(Tube(), options), "tube"));
}

TEST(SurfaceMesher, RefusesCountsThatNoClosedSurfaceHas) {
  SurfaceMesherOptions options;
  for (const int count : {0, -2, 6, 275}) {
    options.triangle_count = count;
    EXPECT_THROW(MeshImplicitSurface(Ball(), options), InputError) << count;
  }
}

TEST(MeshDecimation, RefusesOddAndRaisedCounts) {
  EditableMesh mesh(MarchTetrahedra(Ball(), 0, 1.2e-2));
  EXPECT_THROW(Decimate(101, &mesh), InputError);
  EXPECT_THROW(Decimate(mesh.triangle_count() + 2, &mesh), InputError);
}

TEST(SurfaceMesher, JoinedAndTurnedSurfacesEncloseTheDifference) {
  SurfaceMesherOptions options;
  options.triangle_count = 300;
  const SurfaceMesh outer = MeshImplicitSurface(Ball(), options);
  options.level = -0.01;
  const SurfaceMesh hollow = Joined(outer, TurnedInsideOut(MeshImplicitSurface(Ball(), options)));
  EXPECT_EQ(hollow.triangles.rows(), 600);
  EXPECT_EQ(EdgeDefects(hollow), 0);
  const double wall = 4 * kPi / 3 * (std::pow(kRadius, 3) - std::pow(kRadius - 0.01, 3));
  // The bounds are those of a single surface.
  EXPECT_NEAR(EnclosedVolume(hollow.vertices, hollow.triangles), wall, 2e-4 * wall);
}

TEST(ObjWriter, WritesMicrometresWithoutNegativeZeros) {
  SurfaceMesh mesh;
  mesh.vertices.resize(3, 3);
  mesh.vertices << -1e-7, 0.1234567, -0.25, 1, 0, 0, 0, 1, 0;
  mesh.triangles.resize(1, 3);
  mesh.triangles << 0, 1, 2;
  EXPECT_EQ(ObjText(mesh, "a\nb"),
            "# a\n# b\nv 0.000000 0.123457 -0.250000\nv 1.000000 0.000000 0.000000\n"
            "v 0.000000 1.000000 0.000000\nf 1 2 3\n");
}

TEST(ObjWriter, NamesAPathThatCannotBeWritten) {
  try {
    WriteTextFile("/nonexistent/folder/a.obj", "x");
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("/nonexistent/folder/a.obj"), std::string::npos);
  }
}

}  // namespace
}  // namespace hpdm
