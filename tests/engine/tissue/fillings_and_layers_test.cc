#include "engine/tissue/fillings_and_layers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "engine/base/error.h"
#include "engine/statics/static_loads.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

constexpr double kBarYoung = 5000, kBarLength = 0.2, kBarSide = 0.02;  // Pa, m

// A bar along x whose part below x = 0 is held, with layers.
OrganModel LayeredBar(std::vector<LayerOptions> layers, double poisson, int functions = 0) {
  OrganOptions options;
  options.name = "bar";
  options.material = {.young = kBarYoung, .poisson = poisson};
  options.lattice.cells = {24, 2, 2};
  options.lattice.margin = 0.001;
  options.lattice.local.functions = functions;
  options.layers = std::move(layers);
  options.supports = {{Box{Vector3d(-1, -1, -1), Vector3d(0, 1, 1)}, {}}};
  const double half = kBarSide / 2;
  return OrganModel(options, GridBox(Vector3d(-0.04, -half, -half),
                                     Vector3d(kBarLength, half, half), {48, 6, 6}));
}

LayerOptions Membrane(double stiffness, double poisson,
                      std::optional<Region> region = std::nullopt) {
  return {.region = region, .stiffness = stiffness, .poisson = poisson, .strength = {}};
}

LoadOptions AtTheEnd(const Vector3d& force_W) {
  LoadOptions load;
  load.organ = "bar";
  load.p_centre_W = Vector3d(kBarLength, 0, 0);
  load.radius = 0.012;
  load.force_W = force_W;
  return load;
}

// Mean displacement of the vertices at this place along the bar, m.
Vector3d MeanAt(const OrganModel& bar, const Points& moved, double x) {
  Vector3d sum = Vector3d::Zero();
  int count = 0;
  for (Eigen::Index v = 0; v < moved.rows(); ++v) {
    if (std::abs(bar.rest().vertices(v, 0) - x) > 1e-9) continue;
    sum += moved.row(v).transpose();
    ++count;
  }
  EXPECT_GT(count, 0) << x;
  return sum / count;
}

TEST(FillingsAndLayers, LinearFieldsHaveTheEnergyOfAMembrane) {
  const double stiffness = 30, nu = 0.3, radius = 0.04;
  OrganOptions organ;
  organ.layers = {Membrane(stiffness, nu)};
  const SurfaceMesh ball = Ellipsoid(Vector3d::Constant(radius), 3);
  const Points& normals = ball.vertices;  // of a sphere, not unit: no gaps here
  const FillingsAndLayers surface(organ, ball, normals, 0.005);
  LatticeOptions options;
  const Lattice lattice(BoundingLatticeBox(ball.vertices, SomePose().linear(), 0.01), options);
  Matrix3d G;
  G << 0.01, 0.02, -0.03, 0.04, -0.05, 0.06, 0.07, 0.08, -0.02;
  const Points U = lattice.ControlPoints() * G.transpose();
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(3 * lattice.size(), 3 * lattice.size());
  surface.AddTo(lattice, &K);
  const Eigen::Map<const Eigen::VectorXd> u(U.data(), U.size());
  double exact = 0, tension = 0;
  for (Eigen::Index t = 0; t < ball.triangles.rows(); ++t) {
    const Vector3d twice = TwiceAreaNormal(ball.vertices, ball.triangles, t);
    const Vector3d n = twice.normalized();
    const Matrix3d tangent = Matrix3d::Identity() - n * n.transpose();
    const Matrix3d e = tangent * (G + G.transpose()) / 2 * tangent;
    const Matrix3d stress = stiffness / (1 - nu * nu) * ((1 - nu) * e + nu * e.trace() * tangent);
    exact += 0.25 * twice.norm() * (stress * e).trace();
    tension = std::max(tension, Eigen::SelfAdjointEigenSolver<Matrix3d>(stress).eigenvalues()[2]);
  }
  EXPECT_NEAR(0.5 * u.dot(K * u), exact, 1e-10 * exact);
  // A free organ's frame may have turned.
  const Matrix3d R_WF = SomePose().linear();
  const Points moved = (ball.vertices + ball.vertices * G.transpose()) * R_WF.transpose();
  std::vector<double> largest(surface.tensions().layers());
  surface.tensions().FindLargest(moved, R_WF, largest);
  ASSERT_EQ(largest.size(), 1);
  EXPECT_NEAR(largest[0], tension, 1e-9 * tension);
  EXPECT_LT((K - K.transpose()).norm(), 1e-15 * K.norm());
}

TEST(FillingsAndLayers, RotationsCostNoEnergy) {
  OrganOptions organ;
  organ.layers = {Membrane(30, 0.3)};
  const SurfaceMesh ball = Ellipsoid(Vector3d(0.04, 0.03, 0.02), 3);
  const FillingsAndLayers surface(organ, ball, ball.vertices, 0.005);
  const Lattice lattice(BoundingLatticeBox(ball.vertices, Matrix3d::Identity(), 0.01), {});
  Points U = lattice.ControlPoints();
  for (Eigen::Index a = 0; a < U.rows(); ++a) {
    U.row(a) = Vector3d(1, 2, 3).cross(Vector3d(U.row(a))) + Vector3d(4, 5, 6);
  }
  const Eigen::Map<const Eigen::VectorXd> u(U.data(), U.size());
  EXPECT_LT((surface.LayerRows(lattice) * u).norm(), 1e-10);
}

// A pulled block in a membrane of the same Poisson's ratio: both contract alike, so their stiffness
// adds up to E A + S P with the perimeter P.
TEST(FillingsAndLayers, AMembraneOnABlockAddsItsStiffness) {
  for (const int functions : {0, 27}) {
    const double stiffness = 40, nu = 0.3, force = 0.02;
    const auto stretch = [&](const OrganModel& bar, StaticSolution* solution) {
      *solution = StaticLoads(bar, {AtTheEnd(Vector3d(force, 0, 0))}).Solve();
      const Points& moved = solution->vertex_displacements;
      return (MeanAt(bar, moved, 0.125) - MeanAt(bar, moved, 0.035)).x() / 0.09;
    };
    StaticSolution plain, covered;
    const Box sides{Vector3d(-1, -1, -1), Vector3d(kBarLength - 0.0001, 1, 1)};
    EXPECT_NEAR(stretch(LayeredBar({}, nu, functions), &plain),
                force / (kBarYoung * kBarSide * kBarSide),
                0.02 * force / (kBarYoung * kBarSide * kBarSide));
    const OrganModel bar = LayeredBar({Membrane(stiffness, nu, sides)}, nu, functions);
    const double together = kBarYoung * kBarSide * kBarSide + stiffness * 4 * kBarSide;
    const double strain = stretch(bar, &covered);
    EXPECT_NEAR(strain, force / together, 0.02 * force / together) << functions;
    ASSERT_EQ(covered.layer_tensions.size(), 1);
    EXPECT_GT(covered.layer_tensions[0], 0.98 * stiffness * strain);
  }
}

// A membrane on the upper face alone moves the neutral axis: the composite beam.
TEST(FillingsAndLayers, ATwoLayerBarBendsAsACompositeBeam) {
  const double stiffness = 100;  // as stiff as the whole bar along x
  const Box top{Vector3d(-1, -1, 0.49 * kBarSide), Vector3d(1, 1, 1)};
  const auto bent = [&](const OrganModel& bar) {
    const Points moved =
        StaticLoads(bar, {AtTheEnd(Vector3d(0, 0, -1e-4))}).Solve().vertex_displacements;
    return -(MeanAt(bar, moved, 0.175) - MeanAt(bar, moved, 0)).z();
  };
  const double E_A = kBarYoung * kBarSide * kBarSide, S_b = stiffness * kBarSide,
               half = kBarSide / 2;
  const double centre = S_b * half / (E_A + S_b);
  const double alone = E_A * kBarSide * kBarSide / 12;
  const double composite = alone + E_A * centre * centre + S_b * (half - centre) * (half - centre);
  // Shear is a hundredth of the deflection; the layer leaves it nearly as it is.
  const double a = 0.175, shear = a / (5. / 12 * E_A);
  const auto beam = [&](double EI) { return a * a * (3 * kBarLength - a) / (6 * EI) + shear; };
  EXPECT_NEAR(bent(LayeredBar({Membrane(stiffness, 0, top)}, 0)) / bent(LayeredBar({}, 0)),
              beam(composite) / beam(alone), 0.02 * beam(composite) / beam(alone));
}

TEST(FillingsAndLayers, ALayerInTheAirIsRefused) {
  OrganOptions organ;
  organ.name = "ball";
  organ.layers = {Membrane(1, 0), Membrane(1, 0, Sphere{Vector3d(1, 0, 0), 0.1})};
  const SurfaceMesh ball = Ellipsoid(Vector3d::Constant(0.04), 2);
  try {
    const FillingsAndLayers surface(organ, ball, ball.vertices, 0.01);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("layer[1] meets no outer surface"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace hpdm
