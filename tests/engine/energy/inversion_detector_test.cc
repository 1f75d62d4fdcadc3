#include "engine/energy/inversion_detector.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cstdlib>
#include <numbers>

#include "engine/energy/metric_energy.h"
#include "engine/organ.h"
#include "tests/support/counted_allocations.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

LatticeOptions Lattice3(BasisType basis, int degree) {
  LatticeOptions options;
  options.basis = basis;
  options.degree = {degree, degree, degree};
  options.cells = {3, 2, 4};
  return options;
}

// Every basis over a 0.2 x 0.15 x 0.1 m box that is turned in the world.
class InversionDetectorTest : public testing::TestWithParam<std::pair<BasisType, int>> {
 protected:
  InversionDetectorTest()
      : lattice_({SomePose().translation(), SomePose().linear(), Vector3d(0.2, 0.15, 0.1)},
                 Lattice3(GetParam().first, GetParam().second)),
        tissue_(BoxQuadrature(lattice_.box(), {9, 8, 8})),
        detector_(lattice_, nullptr, tissue_) {}

  Points LinearMap(const Matrix3d& F) const {
    return lattice_.ControlPoints() * (F - Matrix3d::Identity()).transpose();
  }

  Lattice lattice_;
  Quadrature tissue_;
  InversionDetector detector_;
  // Scans all tissue in one call.
  double InvertedShare(const Points& U) const {
    InversionDetector::ScanState scan(detector_);
    const bool inverted = detector_.Inverted(none_, U, 1, &scan);
    EXPECT_EQ(inverted, scan.share > 0);
    return scan.share;
  }

  ActiveRefinement none_{0, 0};
};

TEST_P(InversionDetectorTest, MirroredTissueIsAllInvertedAndTurnedTissueIsNot) {
  EXPECT_EQ(InvertedShare(Points::Zero(lattice_.size(), 3)), 0);
  EXPECT_EQ(detector_.EvaluateAll(none_, Points::Zero(lattice_.size(), 3)).least, 1);
  const Points mirrored = LinearMap(Vector3d(1, -1, 1).asDiagonal());
  EXPECT_NEAR(InvertedShare(mirrored), 1, 1e-12);  // rounding of the sum
  EXPECT_NEAR(detector_.EvaluateAll(none_, mirrored).least, -1, 1e-9);
  // Half a turn is far beyond the bound and inverts no tissue.
  const Points turned =
      LinearMap(Eigen::AngleAxisd(std::numbers::pi, Vector3d(1, 2, 2) / 3).toRotationMatrix());
  EXPECT_EQ(InvertedShare(turned), 0);
  EXPECT_NEAR(detector_.EvaluateAll(none_, turned).least, 1, 1e-9);
}

TEST_P(InversionDetectorTest, TheBoundNeverClearsInvertedTissue) {
  srand(1);
  const Points shape = Points::Random(lattice_.size(), 3);
  bool clear = false, partly = false;
  for (double size = 0.001; size < 0.2; size *= 1.1) {
    const InversionDetector::Inversion all = detector_.EvaluateAll(none_, size * shape);
    EXPECT_NEAR(InvertedShare(size * shape), all.share, 1e-14) << size;
    clear = clear || all.share == 0;
    partly = partly || (all.share > 0 && all.share < 0.3);
  }
  EXPECT_TRUE(clear && partly) << "the sizes cross the border";
}

TEST_P(InversionDetectorTest, DeterminantsAreThoseOfTheLatticesGradients) {
  srand(2);
  const Points U = 0.02 * Points::Random(lattice_.size(), 3);
  const auto gradients = lattice_.GradientWeights(tissue_.points);
  double least = 1;
  for (Eigen::Index q = 0; q < tissue_.points.rows(); ++q) {
    Matrix3d F = Matrix3d::Identity();
    for (int d = 0; d < 3; ++d) F.col(d) += (gradients[d].row(q) * U).transpose();
    least = std::min(least, F.determinant());
  }
  EXPECT_LT(least, 0.9);
  EXPECT_NEAR(detector_.EvaluateAll(none_, U).least, least, 1e-12);
}

TEST_P(InversionDetectorTest, AScanInPiecesFindsTheSame) {
  srand(1);
  const Points U = 0.08 * Points::Random(lattice_.size(), 3);
  const double share = detector_.EvaluateAll(none_, U).share;
  ASSERT_GT(share, 0.01);
  InversionDetector::ScanState scan(detector_);
  int calls = 1;
  bool reported = detector_.Inverted(none_, U, 5, &scan);
  for (; scan.share == 0 && calls < 1000; ++calls) {
    const bool inverted = detector_.Inverted(none_, U, 5, &scan);
    EXPECT_GE(inverted, reported) << "an inversion stays reported until a complete scan finds none";
    reported = inverted;
  }
  EXPECT_GT(calls, 1);
  EXPECT_LE(calls, 5);
  EXPECT_NEAR(scan.share, share, 1e-12);  // rounding of the sum
  // Without unclear cells the report ends at once.
  EXPECT_FALSE(detector_.Inverted(none_, 0 * U, 5, &scan));
}

// Functions at an organ's border may have only a trace of tissue, and move without moving it.
TEST_P(InversionDetectorTest, ControlPointsWithATraceOfTissueDoNotSpoilTheBound) {
  Quadrature inner = tissue_;
  for (Eigen::Index q = 0; q < inner.points.rows(); ++q) {
    const Vector3d c = lattice_.box().ToUnit(inner.points.row(q).transpose());
    inner.points.row(q) = lattice_.box().FromUnit(0.6 * c);
  }
  const InversionDetector detector(lattice_, nullptr, inner);
  Points U = Points::Zero(lattice_.size(), 3);
  U.row(lattice_.size() - 1).setConstant(0.2);  // eight times the spacing
  InversionDetector::ScanState scan(detector);
  EXPECT_FALSE(detector.Inverted(none_, U, 1, &scan));
  EXPECT_EQ(std::count(scan.clear.begin(), scan.clear.end(), false), 0);
}

INSTANTIATE_TEST_SUITE_P(Bases, InversionDetectorTest,
                         testing::Values(std::pair(BasisType::kBSpline, 1),
                                         std::pair(BasisType::kBSpline, 2),
                                         std::pair(BasisType::kBSpline, 3),
                                         std::pair(BasisType::kBernstein, 3)));

// A liver-sized ellipsoid with local functions under two places.
TEST(InversionDetector, LocalFunctionsCount) {
  OrganOptions options;
  options.name = "ellipsoid";
  options.energy.type = EnergyType::kStrain;
  options.lattice.local.functions = 20;
  options.supports = {{BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.25)}, {}}};
  const OrganModel model(options, Ellipsoid(Vector3d(0.1, 0.07, 0.05), 2));
  ActiveRefinement active(model.refinement_basis()->size(), model.RefinementSlots(2));
  const std::array<Vector3d, 2> places = {Vector3d(0.03, 0, 0.04), Vector3d(-0.03, 0, 0.04)};
  active.ChooseNearest(model.refinement_basis()->centres(), places, LocalFunctionsOf(options));
  const int n = model.control_points();
  srand(3);
  Points U = Points::Zero(n + active.slots(), 3);
  U.topRows(n) = 0.002 * Points::Random(n, 3);
  const Points shape = Points::Random(active.slots(), 3);
  bool partly = false;
  InversionDetector::ScanState scan(model.lattice_organ()->inversion_detector());
  for (double size = 0.001; size < 0.1; size *= 1.2) {
    U.bottomRows(active.slots()) = size * shape;
    const InversionDetector::Inversion all =
        model.lattice_organ()->inversion_detector().EvaluateAll(active, U);
    EXPECT_EQ(model.lattice_organ()->inversion_detector().Inverted(active, U, 1, &scan),
              all.share > 0);
    EXPECT_NEAR(scan.share, all.share, 1e-14) << size;
    partly = partly || (all.share > 0 && all.share < 0.3);
  }
  EXPECT_TRUE(partly);
  const long before = AllocationsOfThisThread();
  model.lattice_organ()->inversion_detector().Inverted(active, U, 1, &scan);
  EXPECT_EQ(AllocationsOfThisThread(), before) << "the deformation loop asks every step";
}

}  // namespace
}  // namespace hpdm
