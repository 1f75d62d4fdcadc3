#include "engine/tissue/stiffness_regions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "engine/base/error.h"
#include "engine/organ.h"
#include "engine/statics/static_loads.h"
#include "tests/support/mesh_shapes.h"

namespace hpdm {
namespace {

// A bar of 0.12 x 0.04 x 0.04 m of which x < 0 is held, without Poisson's effect.
OrganOptions BarOfTwo() {
  OrganOptions options;
  options.name = "bar";
  options.energy.type = EnergyType::kStrain;
  options.material.poisson = 0;
  options.lattice.cells = {6, 2, 2};
  options.lattice.local.functions = 0;
  options.lattice.margin = 0.005;
  options.supports = {{Box{Vector3d(-1, -1, -1), Vector3d(0, 1, 1)}, {}}};
  return options;
}

SurfaceMesh BarMesh() { return MakeBox(Vector3d(-0.04, -0.02, -0.02), Vector3d(0.12, 0.02, 0.02)); }

// Returns the displacement (m) of the bar's end under a pull of 10 Pa.
double Stretch(const OrganOptions& options) {
  const OrganModel bar(options, BarMesh());
  LoadOptions pull;
  pull.organ = "bar";
  pull.pressure = -10;
  pull.region = Box{Vector3d(0.1199, -1, -1), Vector3d(1, 1, 1)};
  return StaticLoads(bar, {pull}).Solve().load_displacements[0].x();
}

LoadOptions SidewaysForce(double force) {
  LoadOptions load;
  load.organ = "bar";
  load.p_centre_W = Vector3d(0.12, 0, 0);
  load.radius = 0.01;
  load.force_W = Vector3d(0, 0, force);
  return load;
}

StiffnessTissue Sample(const OrganOptions& options) {
  const SurfaceMesh mesh = BarMesh();
  const OrientedBox box =
      BoundingLatticeBox(mesh.vertices, Matrix3d::Identity(), options.lattice.margin);
  return SampleStiffness(mesh, box, options.lattice.cells, options);
}

TEST(StiffnessRegions, BarOfTwoStiffnessesStretchesAsSpringsInSeries) {
  // The border lies within a cell (of 28 mm), where the strain jumps and a spline's does not.
  OrganOptions options = BarOfTwo();
  const double plain = Stretch(options);
  options.regions = {{Box{Vector3d(0.05, -1, -1), Vector3d(1, 1, 1)}, 10 * options.material.young}};
  const double series = (0.05 + 0.07 / 10) / 0.12;
  // 8 % of the whole: half a cell in which the stiff part holds the soft one back.
  EXPECT_NEAR(Stretch(options) / plain, series, 0.08);
  const double coarse = std::abs(Stretch(options) / plain - series);
  options.lattice.cells = {24, 2, 2};
  const double fine = std::abs(Stretch(options) / plain - series);
  EXPECT_LT(fine, coarse / 2) << "cells of a quarter the length";
}

TEST(StiffnessRegions, RegionOverAllIsTheMaterialsOwnModulus) {
  for (const StrainMeasure strain : {StrainMeasure::kSmall, StrainMeasure::kFinite}) {
    OrganOptions stiff = BarOfTwo(), everywhere = BarOfTwo();
    stiff.energy.strain = everywhere.energy.strain = strain;
    stiff.material.young = 20000;
    everywhere.regions = {{BoxFraction{}, 20000}};
    const OrganModel a(stiff, BarMesh()), b(everywhere, BarMesh());
    const StaticSolution one = StaticLoads(a, {SidewaysForce(1e-3)}).Solve();
    const StaticSolution other = StaticLoads(b, {SidewaysForce(1e-3)}).Solve();
    // More than round-off: the cells are sampled in parts, which moves the points a little. Finite
    // strain has fewer of them (0.28 %).
    const double moved = strain == StrainMeasure::kSmall ? 1e-3 : 5e-3;
    EXPECT_LT((one.vertex_displacements - other.vertex_displacements).norm(),
              moved * one.vertex_displacements.norm());
  }
}

TEST(StiffnessRegions, SoftAndStiffHaveTheirSharesOfTheVolume) {
  OrganOptions options = BarOfTwo();
  constexpr double kRadius = 0.01;
  options.regions = {{Sphere{Vector3d(0.043, 0.002, -0.003), kRadius}, 50}};
  const StiffnessTissue sampled = Sample(options);
  const double whole = Sample(BarOfTwo()).tissue.Volume();
  EXPECT_NEAR(sampled.tissue.Volume(), whole, 1e-9 * whole) << "no tissue is won or lost";
  double inside = 0;
  std::map<std::pair<int, double>, int> points;
  for (Eigen::Index q = 0; q < sampled.stiffness.size(); ++q) {
    ++points[{sampled.tissue.cells[static_cast<std::size_t>(q)], sampled.stiffness[q]}];
    if (sampled.stiffness[q] == 0.01) inside += sampled.tissue.weights[q];
  }
  const double sphere = 4. / 3 * std::numbers::pi * std::pow(kRadius, 3);
  EXPECT_NEAR(inside, sphere, 0.03 * sphere) << "its border in samples of a tenth of its radius";
  for (const auto& [place, count] : points) EXPECT_LE(count, 54);
  EXPECT_TRUE((sampled.tissue.weights.array() > 0).all());
}

TEST(StiffnessRegions, LastRegionCounts) {
  OrganOptions options = BarOfTwo();
  options.regions = {{BoxFraction{}, 1}, {Box{Vector3d(0, -1, -1), Vector3d(1, 1, 1)}, 2}};
  const Box bounds{Vector3d(-0.04, -0.02, -0.02), Vector3d(0.12, 0.02, 0.02)};
  EXPECT_EQ(YoungAt(options, bounds, Vector3d(0.05, 0, 0)), 2);
  EXPECT_EQ(YoungAt(options, bounds, Vector3d(-0.02, 0, 0)), 1);
  options.regions.clear();
  EXPECT_EQ(YoungAt(options, bounds, Vector3d(0.05, 0, 0)), options.material.young);
}

TEST(StiffnessRegions, StiffTumourIsFeltThroughSoftTissue) {
  // A tip on the surface: over the tumour it meets more resistance than beside it.
  for (const EnergyType type : {EnergyType::kStrain, EnergyType::kMetric}) {
    OrganOptions options = BarOfTwo();
    options.energy.type = type;
    options.lattice.cells = {12, 3, 3};
    options.supports = {{Box{Vector3d(-1, -1, -1), Vector3d(1, 1, -0.016)}, {}}};
    options.regions = {{Sphere{Vector3d(0.08, 0, 0), 0.01}, 20 * options.material.young}};
    const OrganModel organ(options, BarMesh());
    const auto compliance = [&organ](double x) {
      LoadOptions press = SidewaysForce(-0.01);
      press.p_centre_W = Vector3d(x, 0, 0.02);
      return StaticLoads(organ, {press}).Solve().Compliance();
    };
    EXPECT_LT(compliance(0.08), 0.9 * compliance(0.02));
  }
}

TEST(StiffnessRegions, RegionWithoutTissueIsRefused) {
  OrganOptions options = BarOfTwo();
  options.regions = {{Sphere{Vector3d(1, 1, 1), 0.01}, 50}};
  try {
    const OrganModel model(options, BarMesh());
    FAIL() << "was accepted";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "organ \"bar\": region[0] holds no tissue; move or enlarge it");
  }
}

}  // namespace
}  // namespace hpdm
