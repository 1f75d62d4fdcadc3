#include "engine/lattice/cut_surface.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <memory>
#include <random>
#include <vector>

#include "engine/base/error.h"
#include "engine/energy/strain_energy.h"
#include "engine/lattice/lattice.h"
#include "engine/tissue/interior.h"
#include "tests/support/shapes.h"

/// Cuts without width, and the functions of a lattice that they divide.

namespace hpdm {
namespace {

const Vector3d kLow(-0.03, -0.02, -0.025), kHigh(0.03, 0.02, 0.025);

SurfaceMesh Body() { return GridBox(kLow, kHigh, {2, 2, 2}); }

/// A strip across x from z = `deep` up to beyond the body's top, bent along y by `bend` (m).
CutOptions Strip(double deep, double bend = 0, const Isometry3d& X = Isometry3d::Identity()) {
  CutOptions cut{.organ = "block", .number = 0, .strip = {}};
  constexpr int kEdges = 9;
  for (int e = 0; e < kEdges; ++e) {
    const double s = 2.0 * e / (kEdges - 1) - 1;
    const double x = 0.0017 + bend * (1 - s * s);
    cut.strip.push_back({X * Vector3d(x, 0.03 * s, 0.03), X * Vector3d(x, 0.03 * s, deep)});
  }
  return cut;
}

/// The body's tissue in a box: around it, or inside it, where no cell meets the body's surface.
enum class Where { kAround, kInside };

struct CutBody {
  explicit CutBody(const std::vector<CutOptions>& strips, Where where = Where::kAround,
                   const Isometry3d& X = Isometry3d::Identity())
      : mesh(Body()) {
    mesh.vertices =
        (mesh.vertices * X.linear().transpose()).rowwise() + X.translation().transpose();
    box = BoundingLatticeBox(mesh.vertices, X.linear(), where == Where::kAround ? 0.002 : -0.004);
    std::vector<CutSurface> surfaces;
    for (const CutOptions& strip : strips) surfaces.emplace_back(box, strip, mesh);
    if (!surfaces.empty()) cuts = std::make_shared<const std::vector<CutSurface>>(surfaces);
  }
  SurfaceMesh mesh;
  OrientedBox box;
  CutSurfaces cuts;
};

struct CutLattice : CutBody {
  explicit CutLattice(const std::vector<CutOptions>& strips, Where where = Where::kAround,
                      const Isometry3d& X = Isometry3d::Identity())
      : CutBody(strips, where, X),
        lattice(box, Options()),
        sampled(
            SampleTissue(mesh, box, Options().cells, {.support_cells = {3, 3, 3}, .cuts = cuts})),
        tissue{sampled.points, sampled.weights} {}
  static LatticeOptions Options() {
    LatticeOptions options;
    options.cells = {4, 3, 4};
    return options;
  }
  void Split() { lattice.SplitByTissue(std::make_shared<const TissuePieces>(sampled.pieces)); }

  Lattice lattice;
  TissueQuadrature sampled;
  Quadrature tissue;
};

FullStiffness Stiffness(const Lattice& lattice, const Quadrature& tissue) {
  return StrainStiffness(lattice, tissue, {}, Dilatation::kPointwise);
}

TEST(CutSurface, NoSegmentSlipsThrough) {
  const CutBody body({Strip(-0.04)});
  const CutSurface& cut = body.cuts->front();
  std::mt19937 random(1);
  std::uniform_real_distribution<double> y(-0.029, 0.029), z(-0.039, 0.029), x(0.0001, 0.02);
  const auto at = [&](double px, double py, double pz) { return cut.At({px, py, pz}); };
  for (int i = 0; i < 2000; ++i) {
    // Every fourth segment meets an edge between two triangles.
    const double py = i % 4 == 0 ? 0.0075 * (i / 4 % 7 - 3) : y(random), pz = z(random);
    const double away = x(random);
    EXPECT_TRUE(cut.Crosses(at(0.0017 - away, py, pz), at(0.0017 + away, py, pz)));
    EXPECT_FALSE(cut.Crosses(at(0.0017 + 1e-9, py, pz), at(0.0017 + away, py, pz)));
    EXPECT_FALSE(cut.Crosses(at(0.0017 - away, py, 0.031), at(0.0017 + away, py, 0.031)));
  }
}

TEST(CutSurface, TheFrontIsTheBorderInTissue) {
  // The strip's lower border, and no other, lies in the body.
  const CutBody body({Strip(0)});
  for (const Vector3d& p : body.cuts->front().front_points()) EXPECT_NEAR(p.z(), 0, 1e-12);
  EXPECT_FALSE(CutBody({Strip(-0.04)}).cuts->front().has_front());
}

TEST(CutSurface, FrontFunctionsJumpAtTheCutOnlyAndHaveTheirGradients) {
  const CutBody body({Strip(0)});
  const CutSurface& cut = body.cuts->front();
  constexpr double kLength = 0.015;
  for (const Vector3d& p : {Vector3d(0.006, 0.003, 0.004), Vector3d(-0.004, 0.003, 0.01),
                            Vector3d(0.004, -0.006, -0.007), Vector3d(0.0018, 0.002, -0.005)}) {
    const FrontValues at = cut.AtFront(p, p, kLength);
    for (int d = 0; d < 3; ++d) {
      constexpr double kStep = 1e-7;
      const Vector3d more = p + kStep * Vector3d::Unit(d), less = p - kStep * Vector3d::Unit(d);
      for (std::size_t k = 0; k < 2; ++k) {
        const double slope = (cut.AtFront(more, more, kLength).value[k] -
                              cut.AtFront(less, less, kLength).value[k]) /
                             (2 * kStep);
        // The second derivative times the step is below 1e-4 of the gradient, about 100 / m.
        EXPECT_NEAR(at.gradient[k][d], slope, 1e-2);
      }
    }
  }
  // On the cut itself the side decides: F1 = +-sqrt(r / h) there and F3 = 0.
  const Vector3d on(0.0017, 0, 0.01), beside(0.001, 0, 0);
  const FrontValues right = cut.AtFront(on, on + beside, kLength),
                    left = cut.AtFront(on, on - beside, kLength);
  EXPECT_NEAR(std::abs(right.value[0]), std::sqrt(0.01 / kLength), 1e-9);
  EXPECT_NEAR(right.value[0] + left.value[0], 0, 1e-12);
  EXPECT_NEAR(right.value[1], 0, 1e-6);
}

TEST(CutSurface, RefusesAStripThatCrossesItselfOrMissesTheTissue) {
  CutOptions crossing{.organ = "block", .number = 0, .strip = {}};
  for (const auto& [x, y] : {std::pair{-0.01, 0.0}, std::pair{0.01, 0.0}, std::pair{0.01, 0.01},
                             std::pair{0.0, -0.01}}) {
    crossing.strip.push_back({{x, y, -0.01}, {x, y, 0.03}});
  }
  EXPECT_THROW(CutBody({crossing}), InputError);
  Isometry3d away = Isometry3d::Identity();
  away.translation().x() = 0.1;
  EXPECT_THROW(CutBody({Strip(0, 0, away)}), InputError);
}

/// Cuts that end in the body or sever it, straight or bent, along the lattice or not.
std::vector<std::pair<CutOptions, Isometry3d>> SomeCuts() {
  return {{Strip(0), Isometry3d::Identity()}, {Strip(-0.003, 0.004, SomePose()), SomePose()}};
}

TEST(Cut, BothSidesTogetherHaveTheIntegralsOfTheWhole) {
  for (const auto& [strip, pose] : SomeCuts()) {
    const CutLattice cut({strip}, Where::kInside, pose), whole({}, Where::kInside, pose);
    const FullStiffness K = Stiffness(whole.lattice, whole.tissue);
    EXPECT_LT((Stiffness(cut.lattice, cut.tissue) - K).norm(),
              1e-11 * K.norm());  // round-off of 1e4 points
    EXPECT_GT(cut.tissue.weights.minCoeff(), 0);
  }
  // Cells that the surface crosses keep what SampleTissue keeps there, which is not all of degree 4.
  const CutLattice cut({Strip(0)}), whole({});
  const FullStiffness K = Stiffness(whole.lattice, whole.tissue);
  EXPECT_LT((Stiffness(cut.lattice, cut.tissue) - K).norm(), 3e-3 * K.norm());
  EXPECT_NEAR(cut.sampled.Volume(), whole.sampled.Volume(), 1e-12 * whole.sampled.Volume());
}

TEST(Cut, TiedLipsGiveTheUncutBody) {
  const CutLattice whole({}, Where::kInside);
  CutLattice cut({Strip(-0.04, 0.006)}, Where::kInside);
  cut.Split();
  ASSERT_GT(cut.lattice.size(), whole.lattice.size() + 10);
  // Ties the copies of each function, the only ones that jump. An elastic ground holds the body.
  Eigen::MatrixXd tie = Eigen::MatrixXd::Zero(3 * cut.lattice.size(), 3 * whole.lattice.size());
  for (int a = 0; a < cut.lattice.size(); ++a) {
    const int column = whole.lattice.Column(cut.lattice.kept()[static_cast<std::size_t>(a)]);
    tie.block<3, 3>(3 * a, 3 * column).setIdentity();
  }
  const auto solve = [](const FullStiffness& K, const Eigen::VectorXd& load) {
    const Eigen::Index n = K.rows();
    return Eigen::VectorXd(
        (K + 1e-3 * K.trace() / n * FullStiffness::Identity(n, n)).llt().solve(load));
  };
  Eigen::VectorXd load = Eigen::VectorXd::Zero(3 * whole.lattice.size());
  whole.lattice.ForEachFunction(Vector3d(0.01, 0, 0.02),
                                [&](int a, double phi) { load[3 * a + 2] = -phi; });
  const Eigen::VectorXd uncut = solve(Stiffness(whole.lattice, whole.tissue), load);
  const Eigen::VectorXd tied =
      solve(tie.transpose() * Stiffness(cut.lattice, cut.tissue) * tie, load);
  EXPECT_LT((tied - uncut).norm(), 1e-9 * uncut.norm());
}

TEST(Cut, ACompleteCutLeavesTwoBodies) {
  CutLattice cut({Strip(-0.04, 0.006)});
  const Lattice uncut = cut.lattice;
  cut.Split();
  cut.lattice.DropControlPointsWithoutTissue(cut.tissue);
  const FullStiffness K = Stiffness(cut.lattice, cut.tissue);
  // Each side built apart: the uncut lattice on the samples of that side.
  const auto on_right = [](const Vector3d& p) {
    const double s = p.y() / 0.03;
    // The strip's edges are chords of the bend, up to 0.1 mm inside of it.
    const double e = std::clamp((s + 1) * 4, 0.0, 8.0), low = std::floor(e);
    const auto x = [](double edge) {
      const double t = edge / 4 - 1;
      return 0.0017 + 0.006 * (1 - t * t);
    };
    return p.x() > x(low) + (e - low) * (x(low + 1) - x(low));
  };
  int functions = 0;
  for (const bool right : {false, true}) {
    std::vector<Eigen::Index> members;
    for (Eigen::Index q = 0; q < cut.tissue.points.rows(); ++q) {
      if (on_right(cut.tissue.points.row(q)) == right) members.push_back(q);
    }
    const Quadrature side{cut.tissue.points(members, Eigen::all), cut.tissue.weights(members)};
    Lattice alone = uncut;
    alone.DropControlPointsWithoutTissue(side);
    functions += alone.size();
    const FullStiffness K_alone = Stiffness(alone, side);
    std::vector<int> column(static_cast<std::size_t>(alone.size()), -1);
    for (const Eigen::Index q : members) {
      std::vector<int> both[2];
      const Vector3d p = cut.tissue.points.row(q);
      alone.ForEachFunction(p, [&](int a, double) { both[0].push_back(a); });
      cut.lattice.ForEachFunction(p, [&](int a, double) { both[1].push_back(a); });
      ASSERT_EQ(both[0].size(), both[1].size());
      for (std::size_t i = 0; i < both[0].size(); ++i) {
        column[static_cast<std::size_t>(both[0][i])] = both[1][i];
      }
    }
    double difference = 0;
    for (int a = 0; a < alone.size(); ++a) {
      for (int b = 0; b < alone.size(); ++b) {
        difference = std::max(difference, (K.block<3, 3>(3 * column[static_cast<std::size_t>(a)],
                                                         3 * column[static_cast<std::size_t>(b)]) -
                                           K_alone.block<3, 3>(3 * a, 3 * b))
                                              .norm());
      }
    }
    EXPECT_LT(difference, 1e-12 * K_alone.norm());
  }
  EXPECT_EQ(functions, cut.lattice.size());  // so nothing couples the two
}

}  // namespace
}  // namespace hpdm
