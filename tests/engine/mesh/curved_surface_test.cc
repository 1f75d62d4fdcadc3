#include "engine/mesh/curved_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tests/support/shapes.h"

namespace hpdm {
namespace {

const Vector3d kRadii(0.1, 0.07, 0.05);  // m

// A mesh with its normals before and after the fit.
struct Curved {
  explicit Curved(SurfaceMesh given) : mesh(std::move(given)) {
    VertexNormals(mesh.vertices, mesh.triangles, &face_means);
    normals = face_means;
    FitNormals(mesh, topology, &normals);
  }
  Vector3d Point(int triangle, const Vector3d& weights) const {
    const SurfacePoint at{triangle, weights};
    return at.Position(mesh.vertices, mesh.triangles) + CurvedOffset(mesh, topology, normals, at);
  }
  // Largest |n . dq| / |dq| along the sides of the triangles, n interpolated from `of`. `curved`: of
  // the curved surface, else of the flat triangles.
  double LargestSlope(const Points& of, bool curved) const {
    constexpr double kStep = 1e-4;
    double largest = 0;
    for (int t = 0; t < static_cast<int>(mesh.triangles.rows()); ++t) {
      for (const double along : {0.1, 0.3, 0.5, 0.8}) {
        const Vector3d at(1 - along, along, 0), next(1 - along - kStep, along + kStep, 0);
        const SurfacePoint flat{t, at}, flat_next{t, next};
        const Vector3d way = curved ? Vector3d(Point(t, next) - Point(t, at))
                                    : Vector3d(flat_next.Position(mesh.vertices, mesh.triangles) -
                                               flat.Position(mesh.vertices, mesh.triangles));
        const Vector3d n = flat.Position(of, mesh.triangles).normalized();
        largest = std::max(largest, std::abs(n.dot(way)) / way.norm());
      }
    }
    return largest;
  }

  SurfaceMesh mesh;
  SurfaceTopology topology{mesh.vertices.rows(), mesh.triangles};
  Points face_means, normals;
};

TEST(CurvedSurface, OfASphereIsTheSphere) {
  constexpr double kRadius = 0.05;
  const Curved sphere(Ellipsoid(Vector3d::Constant(kRadius), 3));
  double most = 0, flat_most = 0;
  for (int t = 0; t < static_cast<int>(sphere.mesh.triangles.rows()); ++t) {
    const Vector3d middle = Vector3d::Constant(1. / 3);
    most = std::max(most, std::abs(sphere.Point(t, middle).norm() - kRadius));
    const Vector3d flat =
        SurfacePoint{t, middle}.Position(sphere.mesh.vertices, sphere.mesh.triangles);
    flat_most = std::max(flat_most, kRadius - flat.norm());
  }
  EXPECT_GT(flat_most, 2e-4);
  EXPECT_LT(most, 0.02 * flat_most) << "fourth order in the edge";
}

// A frictionless press along the normal does no work along the surface.
TEST(CurvedSurface, IsPerpendicularToTheInterpolatedNormals) {
  const Curved body(Ellipsoid(kRadii, 3));
  const double flat = body.LargestSlope(body.face_means, false);
  EXPECT_GT(flat, 0.05);
  EXPECT_LT(body.LargestSlope(body.normals, true), 0.1 * flat);
}

TEST(CurvedSurface, FittedNormalsAreThoseOfTheSmoothBody) {
  const Curved body(Ellipsoid(kRadii, 3));
  double fitted = 0, means = 0;
  for (Eigen::Index v = 0; v < body.mesh.vertices.rows(); ++v) {
    const Vector3d p = body.mesh.vertices.row(v);
    const Vector3d n = p.cwiseQuotient(kRadii.cwiseProduct(kRadii)).normalized();
    fitted = std::max(fitted, (Vector3d(body.normals.row(v)) - n).norm());
    means = std::max(means, (Vector3d(body.face_means.row(v)) - n).norm());
  }
  EXPECT_LT(fitted, 0.6 * means);
}

TEST(CurvedSurface, LeavesFlatFacesAndSharpEdges) {
  const Curved box(GridBox(Vector3d::Zero(), Vector3d(0.1, 0.08, 0.06), {4, 4, 4}));
  for (Eigen::Index v = 0; v < box.normals.rows(); ++v) {
    EXPECT_LT((box.normals.row(v) - box.face_means.row(v)).norm(), 1e-12);
  }
  for (int t = 0; t < static_cast<int>(box.mesh.triangles.rows()); ++t) {
    const SurfacePoint at{t, Vector3d(0.2, 0.5, 0.3)};
    EXPECT_LT(CurvedOffset(box.mesh, box.topology, box.normals, at).norm(), 1e-15);
  }
}

}  // namespace
}  // namespace hpdm
