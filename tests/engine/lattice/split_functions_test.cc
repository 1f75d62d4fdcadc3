#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "engine/energy/finite_strain_energy.h"
#include "engine/energy/inversion_detector.h"
#include "engine/energy/metric_energy.h"
#include "engine/energy/strain_energy.h"
#include "engine/lattice/lattice.h"
#include "engine/organ.h"
#include "engine/statics/static_loads.h"
#include "engine/tissue/interior.h"
#include "tests/support/mesh_shapes.h"
#include "tests/support/shapes.h"

/// Functions split by connected tissue (Lattice::SplitByTissue).

namespace hpdm {
namespace {

constexpr std::array<int, 3> kCells = {4, 2, 6};
constexpr std::array<int, 3> kQuadratic = {3, 3, 3};

/// Two blocks of 30 x 20 x 40 mm side by side along x, `gap` apart.
SurfaceMesh TwoBlocks(double gap) {
  return Joined(MakeBox({-0.03 - gap / 2, -0.01, -0.02}, {-gap / 2, 0.01, 0.02}),
                MakeBox({gap / 2, -0.01, -0.02}, {0.03 + gap / 2, 0.01, 0.02}));
}

/// The same on a plate 10 mm thick: a block with a slit that is open above.
SurfaceMesh Slit(double gap) {
  return Joined(TwoBlocks(gap), MakeBox({-0.03, -0.01, -0.025}, {0.03, 0.01, -0.01}));
}

struct SampledLattice {
  explicit SampledLattice(const SurfaceMesh& mesh, bool split = true, int finer = 1,
                          const Isometry3d& X_WO = Isometry3d::Identity())
      : posed{mesh},
        lattice(BoundingLatticeBox(Pose(&posed, X_WO), X_WO.linear(), 0.001), Options()) {
    sampled = SampleTissue(posed, lattice.box(),
                           {finer * kCells[0], finer * kCells[1], finer * kCells[2]},
                           {.support_cells = kQuadratic});
    tissue = {sampled.points, sampled.weights};
    if (split) lattice.SplitByTissue(std::make_shared<const TissuePieces>(sampled.pieces));
    lattice.DropControlPointsWithoutTissue(tissue);
  }
  static const Points& Pose(SurfaceMesh* mesh, const Isometry3d& X_WO) {
    mesh->vertices =
        (mesh->vertices * X_WO.linear().transpose()).rowwise() + X_WO.translation().transpose();
    return mesh->vertices;
  }
  static LatticeOptions Options() {
    LatticeOptions options;
    options.cells = kCells;
    return options;
  }
  SurfaceMesh posed;
  Lattice lattice;
  TissueQuadrature sampled;
  Quadrature tissue;
};

/// For each column of `split`, the column of the same function in `whole`.
std::vector<int> Whole(const Lattice& split, const Lattice& whole) {
  std::vector<int> columns;
  for (const int index : split.kept()) columns.push_back(whole.Column(index));
  return columns;
}

TEST(SplitFunctions, TheCopiesAddUpToTheFunction) {
  for (const int finer : {1, 2}) {
    const Isometry3d pose = finer == 1 ? Isometry3d(Isometry3d::Identity()) : SomePose();
    const SampledLattice split(Slit(0.002), true, finer, pose);
    const SampledLattice whole(Slit(0.002), false, finer, pose);
    ASSERT_GT(split.lattice.size(), whole.lattice.size() + 4);
    const FullStiffness K =
        StrainStiffness(split.lattice, split.tissue, {}, Dilatation::kPointwise);
    const FullStiffness together =
        StrainStiffness(whole.lattice, split.tissue, {}, Dilatation::kPointwise);
    const std::vector<int> column = Whole(split.lattice, whole.lattice);
    FullStiffness sum = FullStiffness::Zero(together.rows(), together.cols());
    for (int a = 0; a < split.lattice.size(); ++a) {
      for (int b = 0; b < split.lattice.size(); ++b) {
        sum.block<3, 3>(3 * column[a], 3 * column[b]) += K.block<3, 3>(3 * a, 3 * b);
      }
    }
    EXPECT_LT((sum - together).norm(), 1e-12 * together.norm());
    const WeightMatrix weights = split.lattice.Weights(split.tissue.points);
    EXPECT_LT(((weights * Eigen::VectorXd::Ones(weights.cols())).array() - 1).abs().maxCoeff(),
              1e-12);
  }
}

TEST(SplitFunctions, TheSidesOfASlitShareFunctionsBelowItOnly) {
  const SampledLattice slit(Slit(0.002));
  // Above, three cells from the plate, no function reaches both sides.
  const WeightMatrix above =
      slit.lattice.Weights((Points(2, 3) << -0.005, 0, 0.018, 0.005, 0, 0.018).finished());
  for (int a = 0; a < slit.lattice.size(); ++a) {
    EXPECT_EQ(above.coeff(0, a) * above.coeff(1, a), 0) << a;
  }
  const WeightMatrix below =
      slit.lattice.Weights((Points(2, 3) << -0.005, 0, -0.018, 0.005, 0, -0.018).finished());
  int shared = 0;
  for (int a = 0; a < slit.lattice.size(); ++a) shared += below.coeff(0, a) * below.coeff(1, a) > 0;
  EXPECT_GE(shared, 12);
  // A slit narrower than a voxel, half a millimetre here, is not seen.
  EXPECT_FALSE(SampledLattice(Slit(0.0001)).lattice.split());
}

TEST(SplitFunctions, SurfacePointsBelongToTheirSide) {
  // 0.6 mm is little more than a voxel.
  for (const double gap : {0.0006, 0.002}) {
    const SampledLattice blocks(TwoBlocks(gap), true, 1, SomePose());
    Points normals;
    VertexNormals(blocks.posed.vertices, blocks.posed.triangles, &normals);
    const WeightMatrix weights = blocks.lattice.Weights(
        blocks.posed.vertices, blocks.posed.vertices - blocks.lattice.inset() * normals);
    const Eigen::Index half = weights.rows() / 2;
    const Eigen::VectorXd left = weights.topRows(half).transpose() * Eigen::VectorXd::Ones(half);
    const Eigen::VectorXd right =
        weights.bottomRows(half).transpose() * Eigen::VectorXd::Ones(half);
    EXPECT_EQ(left.dot(right), 0) << gap;
    EXPECT_NEAR(left.sum() + right.sum(), static_cast<double>(weights.rows()), 1e-9);
  }
}

TEST(SplitFunctions, RigidMotionsCostNothing) {
  const SampledLattice slit(Slit(0.002), true, 2, SomePose());
  const FullStiffness K =
      StrainStiffness(slit.lattice, slit.tissue, {.poisson = 0.45}, Dilatation::kProjected);
  const Points x = slit.lattice.ControlPoints();
  for (const Points& U : {Points(Eigen::RowVector3d(1, 2, 3).replicate(x.rows(), 1)),
                          Points(x.rowwise().cross(Eigen::RowVector3d(0.3, -1, 2)))}) {
    const Eigen::Map<const Eigen::VectorXd> u(U.data(), U.size());
    EXPECT_LT((K * u).norm(), 1e-9 * K.norm() * u.norm());
  }
}

TEST(SplitFunctions, NoEnergyCouplesSeparateBlocks) {
  const SampledLattice blocks(TwoBlocks(0.002));
  const Lattice& lattice = blocks.lattice;
  std::vector<bool> second(static_cast<std::size_t>(lattice.size()));
  for (Eigen::Index q = 0; q < blocks.tissue.points.rows(); ++q) {
    const Vector3d p = blocks.tissue.points.row(q);
    lattice.ForEachFunction(p, [&](int column, double value) {
      if (p.x() > 0 && value > 0) second[static_cast<std::size_t>(column)] = true;
    });
  }
  Points U = Points::Zero(lattice.size(), 3);
  for (int a = 0; a < lattice.size(); ++a) {
    if (second[static_cast<std::size_t>(a)]) U.row(a) << 0.02, 0.01, -0.01;
  }
  EXPECT_EQ(lattice.size() % 2, 0);
  EXPECT_EQ(std::count(second.begin(), second.end(), true), lattice.size() / 2);
  const Eigen::Map<const Eigen::VectorXd> u(U.data(), U.size());
  for (const Dilatation dilatation : {Dilatation::kPointwise, Dilatation::kProjected}) {
    const MaterialOptions material{.poisson = 0.45};
    const FullStiffness K = StrainStiffness(lattice, blocks.tissue, material, dilatation);
    EXPECT_LT(u.dot(K * u), 1e-12 * K.norm() * u.squaredNorm());
    FiniteStrainEnergy finite(lattice, blocks.tissue, MaterialLaw::kNeoHookean, ToLame(material),
                              dilatation, ScalarStiffness(lattice.size(), lattice.size()));
    EXPECT_LT(finite.Energy(U) - finite.Energy(Points::Zero(U.rows(), 3)),
              1e-12 * K.norm() * u.squaredNorm());
  }
  const ScalarStiffness metric = MetricStiffness(lattice, blocks.tissue, 2000, 0.05);
  EXPECT_LT((U.transpose() * (metric * U)).trace(), 1e-12 * metric.norm() * U.squaredNorm());
  EXPECT_GT(metric.norm(), 0);

  const InversionDetector detector(lattice, nullptr, blocks.tissue);
  InversionDetector::ScanState scan(detector);
  const ActiveRefinement none(0, 0);
  EXPECT_LT(detector.LargestGradient(none, U, &scan), 1e-9);
  U *= 10;  // a gap of many spacings
  EXPECT_FALSE(detector.Inverted(none, U, 1, &scan));
  EXPECT_NEAR(detector.EvaluateAll(none, U).least, 1, 1e-9);
  // Bounds that clear a cell hold for split functions too.
  for (const double size : {0.01, 0.02, 0.05}) {
    const Points random = size * Points::Random(lattice.size(), 3);
    EXPECT_NEAR((detector.Inverted(none, random, 1, &scan), scan.share),
                detector.EvaluateAll(none, random).share, 1e-12);
  }
}

TEST(SplitFunctions, PulledBlocksLeaveTheOtherAlone) {
  OrganOptions organ;
  organ.name = "blocks";
  organ.lattice.cells = {4, 2, 3};
  organ.lattice.margin = 0.001;
  LoadOptions pull;
  pull.organ = "blocks";
  pull.p_centre_W = Vector3d(-0.004, 0, 0.02);
  pull.radius = 0.003;
  pull.force_W = Vector3d(0, 0, 0.01);
  organ.supports.push_back({Box{Vector3d(-1, -1, -1), Vector3d(1, 1, -0.012)}, std::nullopt});
  organ.lattice.local.functions = 20;
  for (const StrainMeasure strain : {StrainMeasure::kSmall, StrainMeasure::kFinite}) {
    organ.energy.strain = strain;
    for (const bool split : {true, false}) {
      organ.lattice.split = split;
      const OrganModel model(organ, TwoBlocks(0.001));
      EXPECT_EQ(model.HasSplitFunctions(), split);
      const Points u = StaticLoads(model, {pull}).Solve().vertex_displacements;
      const double pulled = u.topRows(8).rowwise().norm().maxCoeff(),
                   other = u.bottomRows(8).rowwise().norm().maxCoeff();
      EXPECT_GT(pulled, 1e-5);
      if (split) {
        EXPECT_LT(other, 1e-9 * pulled);
      } else {
        EXPECT_GT(other, 0.05 * pulled);
      }
    }
  }
}

TEST(SplitFunctions, TissueInOnePieceKeepsItsBits) {
  const SurfaceMesh mesh = Ellipsoid(Vector3d(0.1, 0.07, 0.05), 2);
  const Lattice lattice(BoundingLatticeBox(mesh.vertices, Matrix3d::Identity(), 0.01),
                        SampledLattice::Options());
  const TissueQuadrature plain = SampleTissue(mesh, lattice.box(), kCells),
                         sought = SampleTissue(mesh, lattice.box(), kCells,
                                               {.support_cells = kQuadratic});
  EXPECT_TRUE(plain.pieces.empty());
  EXPECT_FALSE(sought.pieces.empty());
  EXPECT_TRUE(plain.points == sought.points && plain.weights == sought.weights);
  Lattice split = lattice;
  split.SplitByTissue(std::make_shared<const TissuePieces>(sought.pieces));
  EXPECT_FALSE(split.split());
  EXPECT_EQ(split.kept(), lattice.kept());
}

TEST(SplitFunctions, EachPieceKeepsItsVolumeAndCentre) {
  // Off the cells, so both blocks and the gap lie in one layer of cells.
  const SampledLattice blocks(TwoBlocks(0.004), true, 1, SomePose());
  const Isometry3d pose = SomePose();
  double volume[2] = {};
  Vector3d moment[2] = {Vector3d::Zero(), Vector3d::Zero()};
  for (Eigen::Index q = 0; q < blocks.tissue.points.rows(); ++q) {
    const Vector3d p = pose.inverse() * Vector3d(blocks.tissue.points.row(q));
    volume[p.x() > 0] += blocks.tissue.weights[q];
    moment[p.x() > 0] += blocks.tissue.weights[q] * p;
  }
  for (const int side : {0, 1}) {
    EXPECT_NEAR(volume[side] / 24e-6, 1, 0.01);
    EXPECT_NEAR(moment[side].x() / volume[side], (side ? 1 : -1) * 0.017, 1e-4);
  }
}

}  // namespace
}  // namespace hpdm
