#include <gtest/gtest.h>

#include <Eigen/LU>
#include <vector>

#include "engine/energy/compressed_quadrature.h"
#include "engine/energy/inversion_detector.h"
#include "engine/energy/metric_energy.h"
#include "engine/energy/mixed_dilatation.h"
#include "engine/energy/strain_energy.h"
#include "engine/lattice/lattice.h"
#include "engine/tissue/interior.h"
#include "tests/support/mesh_shapes.h"
#include "tests/support/shapes.h"

/// Functions of finer levels (Lattice::AddLevel).

namespace hpdm {
namespace {

OrientedBox TurnedBox() {
  return {SomePose().translation(), SomePose().linear(), Vector3d(0.2, 0.15, 0.1)};
}

LatticeOptions Options(int degree, int factor) {
  LatticeOptions options;
  options.degree = {degree, degree, degree};
  options.cells = {3 * factor, 2 * factor, 4 * factor};
  return options;
}

/// Every `every`-th function of a level.
Lattice Part(int degree, int factor, int every) {
  Lattice level(TurnedBox(), Options(degree, factor));
  std::vector<bool> drop(static_cast<std::size_t>(level.size()));
  for (std::size_t a = 0; a < drop.size(); ++a) drop[a] = a % static_cast<std::size_t>(every) != 0;
  level.DropControlPoints(drop);
  return level;
}

Lattice ThreeLevels(int degree) {
  Lattice lattice(TurnedBox(), Options(degree, 1));
  lattice.AddLevel(Part(degree, 2, 3));
  lattice.AddLevel(Part(degree, 4, 7));
  return lattice;
}

Points SomePoints(const OrientedBox& box, int count) {
  Points points(count, 3);
  srand(1);
  for (int q = 0; q < count; ++q) {
    points.row(q) = box.FromUnit((Vector3d::Random() * 0.9 + Vector3d::Ones()) / 2);
  }
  return points;
}

TEST(LatticeLevels, AreTheFunctionsOfTheirOwnLatticesBehindAllOthers) {
  for (int degree = 1; degree <= 3; ++degree) {
    const Lattice lattice = ThreeLevels(degree), coarse(TurnedBox(), Options(degree, 1)),
                  finer = Part(degree, 2, 3), finest = Part(degree, 4, 7);
    ASSERT_EQ(lattice.size(), coarse.size() + finer.size() + finest.size());
    EXPECT_EQ(lattice.FirstColumn(1), coarse.size() + finer.size());
    const Points points = SomePoints(lattice.box(), 60);
    Eigen::MatrixXd expected(60, lattice.size());
    expected << Eigen::MatrixXd(coarse.Weights(points)), Eigen::MatrixXd(finer.Weights(points)),
        Eigen::MatrixXd(finest.Weights(points));
    EXPECT_TRUE(Eigen::MatrixXd(lattice.Weights(points)) == expected);
  }
}

TEST(LatticeLevels, KeepThePartitionOfUnityAndAffineMapsOnTheCoarsestLevel) {
  Matrix3d A;
  A << 0.1, -0.2, 0.3, 0.05, 0.4, -0.1, 0.2, 0.1, -0.3;
  const Lattice lattice = ThreeLevels(2);
  const Points points = SomePoints(lattice.box(), 60);
  Points U = lattice.ControlPoints() * A;
  U.bottomRows(lattice.size() - lattice.FirstColumn(0)).setZero();
  const WeightMatrix weights = lattice.Weights(points);
  EXPECT_LT((weights * U - points * A).cwiseAbs().maxCoeff(), 1e-14);  // round-off
  const Eigen::VectorXd sums =
      Eigen::MatrixXd(weights).leftCols(lattice.FirstColumn(0)).rowwise().sum();
  EXPECT_LT((sums.array() - 1).abs().maxCoeff(), 1e-14);
}

TEST(LatticeLevels, GradientsAreTheDerivativesOfTheWeights) {
  const Lattice lattice = ThreeLevels(2);
  const Points points = SomePoints(lattice.box(), 60);
  const auto gradients = lattice.GradientWeights(points);
  constexpr double kStep = 1e-6;
  for (int d = 0; d < 3; ++d) {
    Points ahead = points, behind = points;
    ahead.col(d).array() += kStep;
    behind.col(d).array() -= kStep;
    const Eigen::MatrixXd slope =
        Eigen::MatrixXd(lattice.Weights(ahead) - lattice.Weights(behind)) / (2 * kStep);
    // Differences of second order of functions with slopes of 100 / m.
    EXPECT_LT((Eigen::MatrixXd(gradients[d]) - slope).cwiseAbs().maxCoeff(), 1e-3);
  }
}

TEST(LatticeLevels, DroppedFunctionsLeaveEveryLevel) {
  Lattice lattice = ThreeLevels(2);
  const Points points = SomePoints(lattice.box(), 60);
  const Eigen::MatrixXd all = lattice.Weights(points);
  std::vector<bool> drop(static_cast<std::size_t>(lattice.size()));
  std::vector<int> kept;
  for (int a = 0; a < lattice.size(); ++a) {
    drop[static_cast<std::size_t>(a)] = a % 4 == 1;
    if (a % 4 != 1) kept.push_back(a);
  }
  lattice.DropControlPoints(drop);
  EXPECT_TRUE(Eigen::MatrixXd(lattice.Weights(points)) == all(Eigen::all, kept));
}

// With all functions of a level in use, the projection is that of the finer lattice.
TEST(LatticeLevels, TheDilatationsProjectionIsRefinedWhereHalfOfTheParentsAreInUse) {
  Lattice lattice(TurnedBox(), Options(2, 1));
  lattice.AddLevel(Lattice(TurnedBox(), Options(2, 2)));
  const Lattice all = LowerDegree(lattice), finer(TurnedBox(), Options(1, 2));
  EXPECT_EQ(all.levels().at(0).size(), finer.size());

  // The functions of one corner of the box: i, j, k < 4.
  Lattice corner(TurnedBox(), Options(2, 2));
  const TensorBasis& basis = corner.basis();
  std::vector<bool> drop(static_cast<std::size_t>(corner.size()), true);
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      for (int k = 0; k < 4; ++k) drop[static_cast<std::size_t>(basis.Index(i, j, k))] = false;
    }
  }
  corner.DropControlPoints(drop);
  Lattice part(TurnedBox(), Options(2, 1));
  part.AddLevel(corner);
  const Lattice lower = LowerDegree(part);
  const Lattice& of = lower.levels().at(0);
  // Parents i, i + 1: both in use for i < 3, one for i = 3. Half of eight: at most one axis at 3.
  int expected = 0;
  for (int i = 0; i <= 3; ++i) {
    for (int j = 0; j <= 3; ++j) {
      for (int k = 0; k <= 3; ++k) expected += (i == 3) + (j == 3) + (k == 3) <= 1;
    }
  }
  EXPECT_EQ(of.size(), expected);
}

// The blocks are summed point by point by one way, cell by cell by the other.
TEST(LatticeLevels, TheStiffnessIsThatOfItsFunctions) {
  const Lattice lattice = ThreeLevels(2);
  const Quadrature tissue = BoxQuadrature(lattice.box(), {12, 8, 16});
  const MaterialOptions material = {.young = 5000, .poisson = 0.3};
  const FullStiffness K = StrainStiffness(lattice, tissue, material, Dilatation::kPointwise);
  FullStiffness expected = FullStiffness::Zero(K.rows(), K.cols());
  const auto gradients = lattice.GradientWeights(tissue.points);
  AddElasticBlocks(
      gradients, gradients, tissue.weights, ToLame(material),
      [&](Eigen::Index row, Eigen::Index column, double value) { expected(row, column) += value; });
  EXPECT_LT((K - expected).cwiseAbs().maxCoeff(), 1e-12 * K.cwiseAbs().maxCoeff());
}

// The moments are those of the pieces between the finest knots that a function has.
TEST(LatticeLevels, CompressedPointsKeepTheStiffness) {
  SurfaceMesh mesh = Ellipsoid(Vector3d(0.09, 0.06, 0.04), 3, SomePose());
  const OrientedBox box = BoundingLatticeBox(mesh.vertices, SomePose().linear(), 0.005);
  Lattice lattice(box, Options(2, 1)), finer(box, Options(2, 2));
  std::vector<bool> drop(static_cast<std::size_t>(finer.size()));
  for (std::size_t a = 0; a < drop.size(); ++a) drop[a] = a % 3 != 0;
  finer.DropControlPoints(drop);
  lattice.AddLevel(finer);
  const TissueQuadrature sampled = SampleTissue(mesh, box, {12, 8, 16});
  const Quadrature tissue{sampled.points, sampled.weights};
  const Quadrature few = CompressedQuadrature(lattice, nullptr, tissue, 3);
  EXPECT_LT(few.weights.size(), tissue.weights.size());
  EXPECT_NEAR(few.weights.sum(), tissue.weights.sum(), 1e-12 * tissue.weights.sum());
  const MaterialOptions material = {.young = 5000, .poisson = 0.3};
  const FullStiffness K = StrainStiffness(lattice, few, material, Dilatation::kPointwise),
                      full = StrainStiffness(lattice, tissue, material, Dilatation::kPointwise);
  // Products of slopes of quadratic splines have terms beyond these moments.
  EXPECT_LT((K - full).norm(), 5e-3 * full.norm());
}

TEST(LatticeLevels, TheInversionDetectorSeesWhatFinerFunctionsInvert) {
  const Lattice lattice = ThreeLevels(2);
  const Quadrature tissue = BoxQuadrature(lattice.box(), {12, 8, 16});
  const InversionDetector detector(lattice, nullptr, tissue);
  const ActiveRefinement none(0, 0);
  const auto gradients = lattice.GradientWeights(tissue.points);
  srand(1);
  bool inverts = false, clear = false;
  for (double size = 0.001; size < 0.1; size *= 1.3) {
    Points U = Points::Zero(lattice.size(), 3);
    U.bottomRows(lattice.size() - lattice.FirstColumn(0)) =
        size * Points::Random(lattice.size() - lattice.FirstColumn(0), 3);
    double inverted = 0;
    for (Eigen::Index q = 0; q < tissue.weights.size(); ++q) {
      Matrix3d F = Matrix3d::Identity();
      for (int d = 0; d < 3; ++d) F.col(d) += (gradients[d].row(q) * U).transpose();
      if (!(F.determinant() > 0)) inverted += tissue.weights[q] / tissue.weights.sum();
    }
    EXPECT_NEAR(detector.EvaluateAll(none, U).share, inverted, 1e-12) << size;
    InversionDetector::ScanState scan(detector);
    detector.Inverted(none, U, 1, &scan);
    EXPECT_NEAR(scan.share, inverted, 1e-12) << size;
    inverts = inverts || inverted > 0;
    clear = clear || inverted == 0;
  }
  EXPECT_TRUE(inverts && clear) << "the sizes cross the border";
}

}  // namespace
}  // namespace hpdm
