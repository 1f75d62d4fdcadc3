// Organs with filled lumens: pressure, volume, and what uniform pressure does to them.

#include <gtest/gtest.h>

#include <numbers>
#include <vector>

#include "engine/statics/static_loads.h"
#include "tests/support/mesh_shapes.h"
#include "tools/shared/organ_bench.h"

namespace hpdm {
namespace {

constexpr double kMiddle = 0.04, kWall = 0.002;  // m
constexpr double kWallYoung = 2e4;               // Pa

// A hollow sphere, held at its bottom or by a weak spring.
struct HollowSphere {
  std::optional<double> bulk_modulus = std::nullopt;  // Pa; none: empty
  double poisson = 0.3;
  double wall = kWall;  // m
  int cells = 7;
  int functions = 0;
  bool held = false;

  OrganModel Build() const {
    OrganOptions options;
    options.name = "sphere";
    options.material = {.young = kWallYoung, .poisson = poisson};
    options.lattice.cells = {cells, cells, cells};
    options.lattice.margin = 0.001;
    options.lattice.local.functions = functions;
    if (held) {
      options.supports = {{hpdm::Box{Vector3d(-1, -1, -1), Vector3d(1, 1, -0.6 * kMiddle)}, {}}};
    }
    if (bulk_modulus) {
      options.lumens.emplace_back().bulk_modulus = *bulk_modulus;
    }
    return OrganModel(options, Joined(MakeSphere(4, kMiddle + wall / 2),
                                      Reversed(MakeSphere(4, kMiddle - wall / 2))));
  }
};

LoadOptions SpherePressure(double pressure) {
  LoadOptions load;
  load.organ = "sphere";
  load.pressure = pressure;
  return load;
}

// On the wall of the cavity.
LoadOptions InnerPressure(double pressure) {
  LoadOptions load = SpherePressure(pressure);
  load.region = Sphere{Vector3d::Zero(), kMiddle};
  return load;
}

LoadOptions PressOnTop(double force) {
  LoadOptions load;
  load.organ = "sphere";
  load.p_centre_W = Vector3d(0, 0, kMiddle);
  load.radius = 0.015;
  load.force_W = Vector3d(0, 0, -force);
  return load;
}

double CavityChange(const OrganModel& organ, const Points& displacements) {
  OrganOptions filled;
  filled.lumens.emplace_back();
  return RelativeChange(FilledLumens(organ.rest(), filled).at(0), displacements);
}

// A pull q all around outside, which the wall's tension and the fluid share: q R_o^2 + p R_i^2 = 2 T R
// on a half of the sphere, with T by Hooke's law from the wall's stretch.
TEST(FilledOrgan, ThinSpheresTensionBalancesTheFluidsPressure) {
  const double pull = 100, outside = kMiddle + kWall / 2, inside = kMiddle - kWall / 2;
  const OrganModel sphere = HollowSphere{.bulk_modulus = 1000}.Build();
  const StaticSolution solution =
      StaticLoads(sphere, {SpherePressure(-pull), InnerPressure(pull)}).Solve();
  ASSERT_EQ(solution.lumen_pressures.size(), 1);
  const double pressure = solution.lumen_pressures[0];
  double stretch = 0;
  for (Eigen::Index v = 0; v < sphere.rest().vertices.rows(); ++v) {
    stretch += sphere.rest().vertices.row(v).normalized().dot(solution.vertex_displacements.row(v));
  }
  stretch /= static_cast<double>(sphere.rest().vertices.rows()) * kMiddle;
  const double nu = sphere.options().material.poisson, across = (pull - pressure) / 2;
  const double tension = kWall * (kWallYoung * stretch + nu * across) / (1 - nu);
  const double balanced = (2 * tension * kMiddle - pull * outside * outside) / (inside * inside);
  EXPECT_LT(pressure, -0.3 * pull) << "the fluid takes a part";
  EXPECT_GT(pressure, -0.7 * pull);
  EXPECT_NEAR(pressure, balanced, 0.02 * std::abs(pressure));
}

// The second way: the cavity's pressure that brings the empty organ back to its volume.
TEST(FilledOrgan, IsTheEmptyOneUnderThePressureThatKeepsTheVolume) {
  for (const int functions : {0, 27}) {
    HollowSphere sphere{.cells = 4, .functions = functions, .held = true};
    const OrganModel empty = sphere.Build();
    sphere.bulk_modulus = 2.2e9;
    const OrganModel filled = sphere.Build();
    const LoadOptions press = PressOnTop(0.1);
    const Points pressed =
        StaticLoads(empty, {press, InnerPressure(0)}).Solve().vertex_displacements;
    LoadOptions none = press;
    none.force_W = Vector3d::Zero();
    const Points blown = StaticLoads(empty, {none, InnerPressure(1)}).Solve().vertex_displacements;
    const double pressure = -CavityChange(empty, pressed) / CavityChange(empty, blown);
    const StaticSolution solution = StaticLoads(filled, {press}).Solve();
    EXPECT_LT(std::abs(CavityChange(filled, solution.vertex_displacements)), 1e-6) << functions;
    EXPECT_NEAR(solution.lumen_pressures.at(0), pressure, 0.01 * pressure) << functions;
    const Points expected = pressed + pressure * blown;
    EXPECT_LT((solution.vertex_displacements - expected).norm(), 0.01 * expected.norm())
        << functions;
    EXPECT_LT(solution.vertex_displacements.norm(), 0.99 * pressed.norm()) << "it is stiffer";
  }
}

// Gas around a filled, nearly incompressible organ: the fluid takes the pressure on, and the wall is
// only squeezed by its own compressibility.
TEST(FilledOrgan, UniformPressureAroundItDoesNotDeformIt) {
  const double gas = 1600;  // Pa, 12 mmHg
  const auto largest = [&](const OrganModel& organ) {
    return StaticLoads(organ, {SpherePressure(gas), InnerPressure(-gas)})
        .Solve()
        .vertex_displacements.rowwise()
        .norm()
        .maxCoeff();
  };
  const OrganModel filled = HollowSphere{.bulk_modulus = 2.2e9, .poisson = 0.49}.Build();
  EXPECT_LT(largest(filled), 0.02 * largest(HollowSphere{.poisson = 0.49}.Build()));
  const StaticSolution solution =
      StaticLoads(filled, {SpherePressure(gas), InnerPressure(-gas)}).Solve();
  EXPECT_NEAR(solution.lumen_pressures.at(0), gas, 0.02 * gas);
}

// A step's contact, with local functions and a dent, and the compliance that the hand feels.
TEST(FilledOrgan, AStepKeepsTheVolumeAndTheHandFeelsIt) {
  std::vector<double> forces, compliances;
  for (const bool full : {false, true}) {
    HollowSphere sphere{.wall = 0.004, .cells = 4, .functions = 27, .held = true};
    if (full) sphere.bulk_modulus = 2.2e9;
    const OrganModel built = sphere.Build();
    OrganBench bench;
    bench.Add(built.options(), built.rest());
    bench.Start();
    const ToolPose tool = OrganBench::Above(Vector3d(0, 0, 0.042 + kDefaultToolRadius - 0.004));
    for (int step = 0; step < 5; ++step) bench.Step(tool);
    const Points moved = bench.organ(0).vertices - bench.model(0).rest().vertices;
    if (full) {
      EXPECT_LT(std::abs(CavityChange(bench.model(0), moved)), 1e-6);
    } else {
      EXPECT_GT(std::abs(CavityChange(bench.model(0), moved)), 1e-4);
    }
    forces.push_back(bench.ToolForce(0).z());
    compliances.push_back(bench.patch.Front().tools[0].main().compliance_W(2, 2));
  }
  EXPECT_LT(forces[1], 1.01 * forces[0]) << "pressed down: the filled one presses back harder";
  EXPECT_LT(compliances[1], 0.99 * compliances[0]);
}

}  // namespace
}  // namespace hpdm
