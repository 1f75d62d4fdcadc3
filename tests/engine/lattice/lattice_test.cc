#include "engine/lattice/lattice.h"

#include <gtest/gtest.h>

#include "engine/energy/metric_energy.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

std::vector<LatticeOptions> AllLattices() {
  std::vector<LatticeOptions> all;
  for (int degree = 1; degree <= 3; ++degree) {
    LatticeOptions options;
    options.degree = {degree, degree, degree};
    options.cells = {3, 4, 2};
    all.push_back(options);
  }
  LatticeOptions bernstein;
  bernstein.basis = BasisType::kBernstein;
  bernstein.degree = {3, 4, 2};
  all.push_back(bernstein);
  return all;
}

TEST(Lattice, EquationFourReproducesTheRestSurface) {
  const SurfaceMesh mesh = Ellipsoid(Vector3d(0.1, 0.07, 0.05), 2, SomePose());
  for (const LatticeOptions& options : AllLattices()) {
    const Lattice lattice(BoundingLatticeBox(mesh.vertices, SomePose().linear(), 0.02), options);
    const Points rebuilt = lattice.Weights(mesh.vertices) * lattice.ControlPoints();
    // Round-off of metres-sized numbers.
    EXPECT_LT((rebuilt - mesh.vertices).cwiseAbs().maxCoeff(), 1e-14);
  }
}

TEST(Lattice, ReproducesAnyAffineMap) {
  const SurfaceMesh mesh = Ellipsoid(Vector3d(0.1, 0.07, 0.05), 1, SomePose());
  Matrix3d A;
  A << 0.1, -0.2, 0.3, 0.05, 0.4, -0.1, 0.2, 0.1, -0.3;
  for (const LatticeOptions& options : AllLattices()) {
    const Lattice lattice(BoundingLatticeBox(mesh.vertices, Matrix3d::Identity(), 0.01), options);
    const Points moved = lattice.Weights(mesh.vertices) * Points(lattice.ControlPoints() * A);
    EXPECT_LT((moved - mesh.vertices * A).cwiseAbs().maxCoeff(), 1e-14);
  }
}

TEST(Lattice, GradientsAreTheDerivativesOfTheWeights) {
  const SurfaceMesh mesh = Ellipsoid(Vector3d(0.1, 0.07, 0.05), 1, SomePose());
  for (const LatticeOptions& options : AllLattices()) {
    const Lattice lattice(BoundingLatticeBox(mesh.vertices, SomePose().linear(), 0.01), options);
    // Away from the cells' faces, where the slope of linear splines jumps.
    Points points(50, 3);
    srand(1);
    for (int q = 0; q < 50; ++q) {
      points.row(q) = lattice.box().FromUnit((Vector3d::Random() * 0.9 + Vector3d::Ones()) / 2);
    }
    const auto gradients = lattice.GradientWeights(points);
    for (int d = 0; d < 3; ++d) {
      constexpr double kStep = 1e-6;
      Points ahead = points, behind = points;
      ahead.col(d).array() += kStep;
      behind.col(d).array() -= kStep;
      const Eigen::MatrixXd difference =
          Eigen::MatrixXd(lattice.Weights(ahead) - lattice.Weights(behind)) / (2 * kStep);
      // Round-off of the difference, 1e-16 / 1e-6, against slopes of about 1 / cell, 30 per m.
      EXPECT_LT((Eigen::MatrixXd(gradients[d]) - difference).norm(), 1e-7 * difference.norm());
    }
  }
}

TEST(Lattice, BoxHoldsTheVerticesAndTheMargin) {
  const SurfaceMesh mesh = Ellipsoid(Vector3d(0.1, 0.07, 0.05), 2, SomePose());
  const OrientedBox box = BoundingLatticeBox(mesh.vertices, SomePose().linear(), 0.02);
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    const Vector3d p = mesh.vertices.row(v);
    const Vector3d c = box.ToUnit(p);
    const Vector3d to_border = c.cwiseMin(Vector3d::Ones() - c).cwiseProduct(box.lengths);
    EXPECT_GE(to_border.minCoeff(), 0.02 - 1e-12);
    EXPECT_LT((box.FromUnit(c) - p).norm(), 1e-14);
  }
}

TEST(Lattice, DropsExactlyTheControlPointsWithoutTissue) {
  // Tissue in one corner cell of 4 x 4 x 4 quadratic cells: 27 functions reach it.
  LatticeOptions options;
  Lattice lattice(OrientedBox{}, options);
  const OrientedBox corner{Vector3d::Zero(), Matrix3d::Identity(), Vector3d::Constant(0.25)};
  lattice.DropControlPointsWithoutTissue(BoxQuadrature(corner, {3, 3, 3}));
  EXPECT_EQ(lattice.size(), 27);
  const WeightMatrix weights = lattice.Weights(Vector3d(0.1, 0.2, 0.15).transpose());
  EXPECT_NEAR(weights.sum(), 1, 1e-15);
}

}  // namespace
}  // namespace hpdm
