#include "engine/statics/static_loads.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>

#include "engine/base/error.h"
#include "tests/support/mesh_shapes.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

// An ellipsoid of 0.1 x 0.07 x 0.05 m half-axes (times `scale`) held in its lower part.
OrganModel Organ(EnergyType energy, double scale = 1) {
  OrganOptions options;
  options.name = "ellipsoid";
  options.energy.type = energy;
  options.lattice.local.functions = 0;
  options.energy.beta *= scale * scale;
  options.lattice.margin *= scale;
  SupportOptions bottom;
  bottom.region = BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.27)};
  options.supports.push_back(bottom);
  return OrganModel(options, Ellipsoid(scale * Vector3d(0.1, 0.07, 0.05), 3));
}

LoadOptions LoadAt(const Vector3d& p, double radius) {
  LoadOptions load;
  load.organ = "ellipsoid";
  load.p_centre_W = p;
  load.radius = radius;
  return load;
}

LoadOptions Force(const Vector3d& p, const Vector3d& force) {
  LoadOptions load = LoadAt(p, 0.015);
  load.force_W = force;
  return load;
}

const Vector3d kTop(0.01, 0.005, 0.0494), kSide(0.0985, 0.008, 0.007);

TEST(StaticLoads, BernsteinLatticeOfDegreeTwentyIsSolved) {
  // The functions are nearly dependent: the condition of K is 1e14, but that of its effect on
  // tissue is small.
  OrganOptions options;
  options.name = "bar";
  options.energy.type = EnergyType::kStrain;
  options.material.poisson = 0;
  options.lattice.basis = BasisType::kBernstein;
  options.lattice.cells = {1, 1, 1};
  options.lattice.degree = {20, 2, 2};
  options.lattice.margin = 0.005;
  options.supports = {{Box{Vector3d(-1, -1, -1), Vector3d(0, 1, 1)}, {}}};
  const OrganModel bar(options, MakeBox(Vector3d(-0.04, -0.01, -0.01), Vector3d(0.2, 0.01, 0.01)));
  const StaticSolution bent = StaticLoads(bar, {Force({0.2, 0, 0}, {0, 0, 1e-4})}).Solve();
  // Timoshenko's beam; 5 %: where the support ends and the load's patch is on the end face.
  const double inertia = std::pow(0.02, 4) / 12, young = options.material.young;
  const double beam = std::pow(0.2, 3) / (3 * young * inertia) + 0.2 / (5. / 12 * young * 4e-4);
  EXPECT_NEAR(bent.Compliance(), beam, 0.05 * beam);
}

TEST(StaticLoads, FreeBodysStiffnessIsRefused) {
  for (const int cells : {2, 4}) {
    LatticeOptions options;
    options.cells = {cells, cells, cells};
    const Lattice lattice({Vector3d::Zero(), Matrix3d::Identity(), Vector3d(0.2, 0.1, 0.1)},
                          options);
    const Quadrature tissue = BoxQuadrature(lattice.box(), {12, 12, 12});
    const FullStiffness K = StrainStiffness(lattice, tissue, {}, Dilatation::kProjected);
    EXPECT_THROW(MakeComplianceSolver(K), InputError);
  }
}

class StaticLoadsTest : public testing::TestWithParam<EnergyType> {
 protected:
  OrganModel organ_ = Organ(GetParam());
};
INSTANTIATE_TEST_SUITE_P(Energies, StaticLoadsTest,
                         testing::Values(EnergyType::kMetric, EnergyType::kStrain));

TEST_P(StaticLoadsTest, SolutionBalancesTheLoads) {
  const StaticLoads loads(organ_, {Force(kTop, {0.2, 0, -1}), Force(kSide, {-0.5, 0, 0})});
  const StaticSolution solution = loads.Solve();
  EXPECT_LT(loads.Residual(solution), 1e-10);  // round-off times the condition of K, about 1e5
  EXPECT_GT(solution.Compliance(), 0);
}

TEST_P(StaticLoadsTest, LoadsSuperpose) {
  const LoadOptions a = Force(kTop, {0.2, 0, -1}), b = Force(kSide, {-0.5, 0, 0});
  const Points together = StaticLoads(organ_, {a, b}).Solve().vertex_displacements;
  const Points apart = StaticLoads(organ_, {a}).Solve().vertex_displacements +
                       StaticLoads(organ_, {b}).Solve().vertex_displacements;
  EXPECT_LT((together - apart).norm(), 1e-10 * together.norm());
}

TEST_P(StaticLoadsTest, WorkIsReciprocal) {
  // Maxwell and Betti: u at b from a force at a, times the force at b, is the same the other way.
  const Vector3d fa(0.2, 0, -1), fb(-0.5, 0.1, 0);
  const StaticSolution from_a =
      StaticLoads(organ_, {Force(kTop, fa), Force(kSide, Vector3d::Zero())}).Solve();
  const StaticSolution from_b =
      StaticLoads(organ_, {Force(kTop, Vector3d::Zero()), Force(kSide, fb)}).Solve();
  const double ab = from_a.load_displacements[1].dot(fb);
  const double ba = from_b.load_displacements[0].dot(fa);
  EXPECT_NEAR(ab / ba, 1, 1e-9);
}

TEST_P(StaticLoadsTest, PrescribedDisplacementTakesTheForceThatMakesIt) {
  const Vector3d force(0.2, 0, -1);
  const StaticSolution by_force = StaticLoads(organ_, {Force(kTop, force)}).Solve();
  LoadOptions load = LoadAt(kTop, 0.015);
  load.displacement_W = by_force.load_displacements[0];
  const StaticSolution by_displacement = StaticLoads(organ_, {load}).Solve();
  EXPECT_LT((by_displacement.load_forces[0] - force).norm(), 1e-9 * force.norm());
  EXPECT_LT((by_displacement.vertex_displacements - by_force.vertex_displacements).norm(),
            1e-9 * by_force.vertex_displacements.norm());
}

TEST_P(StaticLoadsTest, BodyRescaledByAThousandHasTheSameShape) {
  // Forces grow with the square of the length at equal stress.
  const double scale = 1000;
  const OrganModel large = Organ(GetParam(), scale);
  LoadOptions load = LoadAt(scale * kTop, scale * 0.015);
  load.force_W = scale * scale * Vector3d(0.2, 0, -1);
  const Points big = StaticLoads(large, {load}).Solve().vertex_displacements / scale;
  const Points small =
      StaticLoads(organ_, {Force(kTop, {0.2, 0, -1})}).Solve().vertex_displacements;
  // Round-off times the condition of K with its diagonal scaled to one, 1e4 (functions with a
  // sliver of tissue are soft, not ill-conditioned): measured below 1e-13 for both energies.
  EXPECT_LT((big - small).norm(), 1e-11 * small.norm());
}

LoadOptions Pressure(double pressure, std::optional<Region> region = std::nullopt) {
  LoadOptions load;
  load.organ = "ellipsoid";
  load.pressure = pressure;
  load.region = std::move(region);
  return load;
}

TEST(StaticLoads, PressureAllAroundShrinksAFreeBodyEvenly) {
  // The field -(1 - 2 nu) p x / E is linear, so the lattice holds it exactly; the weak spring that
  // stands for a support takes 1e-3 of E / L^2, and the parts that the surface cuts are integrated
  // to a per cent.
  OrganOptions options;
  options.name = "ellipsoid";
  options.energy.type = EnergyType::kStrain;
  options.lattice.local.functions = 0;
  options.material.poisson = 0.3;
  const OrganModel organ(options, Ellipsoid(Vector3d(0.1, 0.07, 0.05), 3));
  const StaticLoads loads(organ, {Pressure(100)});
  const StaticSolution solution = loads.Solve();
  const Points expected =
      -(1 - 2 * options.material.poisson) * 100 / options.material.young * organ.rest().vertices;
  EXPECT_LT((solution.vertex_displacements - expected).norm(), 0.02 * expected.norm());
  EXPECT_EQ(solution.load_forces[0], Vector3d::Zero());
  EXPECT_EQ(solution.Compliance(), 0);
  EXPECT_LT(loads.Residual(solution), 1e-9);  // round-off times the condition of K
}

TEST(StaticLoads, PressureSumsToItsAreaAndSuperposes) {
  const OrganModel organ = Organ(EnergyType::kStrain);
  const double top = 0.02;
  const Region upper = Box{Vector3d(-1, -1, top), Vector3d(1, 1, 1)};
  const StaticSolution pressed = StaticLoads(organ, {Pressure(200, upper)}).Solve();
  // Compares with the cut at z = 0.02, an ellipse; the edge is as sharp as a part of a quarter
  // spacing.
  const double shrink = 1 - std::pow(top / 0.05, 2);
  const double area = std::numbers::pi * 0.1 * 0.07 * shrink;
  EXPECT_NEAR(pressed.load_forces[0].z() / (-200 * area), 1, 0.05);
  EXPECT_LT(pressed.load_forces[0].head<2>().norm(), 0.02 * 200 * area);
  const LoadOptions side = Force(kSide, {-0.5, 0, 0});
  const Points both = StaticLoads(organ, {side, Pressure(200, upper)}).Solve().vertex_displacements;
  const Points alone = StaticLoads(organ, {side}).Solve().vertex_displacements;
  EXPECT_LT((both - alone - pressed.vertex_displacements).norm(), 1e-10 * both.norm());
}

TEST(StaticLoads, PressureWithoutSurfaceIsRefused) {
  const OrganModel organ = Organ(EnergyType::kMetric);
  EXPECT_THROW(StaticLoads(organ, {Pressure(1, Sphere{Vector3d(0, 0, 1), 0.1})}), InputError);
}

TEST(StaticLoads, LoadAwayFromTheSurfaceIsRefused) {
  const OrganModel organ = Organ(EnergyType::kMetric);
  EXPECT_THROW(StaticLoads(organ, {Force(Vector3d(0, 0, 0.2), {0, 0, -1})}), InputError);
}

// With linear splines over one cell a fixed support holds only the mean: the organ could rotate
// about it.
TEST(StaticLoads, ALatticeThatLeavesARotationFreeIsRefused) {
  OrganOptions options;
  options.name = "ellipsoid";
  options.energy.type = EnergyType::kStrain;
  options.lattice.basis = BasisType::kBernstein;
  options.lattice.degree = {1, 1, 1};
  options.lattice.cells = {1, 1, 1};
  options.supports.push_back({BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.27)}, {}});
  const OrganModel organ(options, Ellipsoid(Vector3d(0.1, 0.07, 0.05), 3));
  EXPECT_THROW(StaticLoads(organ, {Force(kTop, {0, 0, -1})}), InputError);
}

}  // namespace
}  // namespace hpdm
