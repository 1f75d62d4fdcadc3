#include "engine/reference_fem/fine_lattice.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/base/error.h"
#include "engine/baselines/surface_error.h"
#include "engine/organ.h"
#include "engine/statics/static_loads.h"
#include "tests/support/mesh_shapes.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

struct Body {
  OrganOptions organ;
  SurfaceMesh rest;
};

// An ellipsoid of 0.2 x 0.14 x 0.1 m, its left third held.
Body HeldEllipsoid() {
  Body body;
  body.rest = Ellipsoid(Vector3d(0.1, 0.07, 0.05), 3);
  body.organ.name = "body";
  body.organ.energy.type = EnergyType::kStrain;
  body.organ.lattice.local.functions = 0;
  body.organ.supports = {{BoxFraction{Vector3d::Zero(), Vector3d(0.35, 1, 1)}, std::nullopt}};
  return body;
}

LoadOptions PressOnTop(const Vector3d& force_W) {
  LoadOptions load;
  load.p_centre_W = {0.03, 0, 0.05};
  load.radius = 0.015;
  load.force_W = force_W;
  return load;
}

// Returns the solution of the lattice of the same cells and box, solved directly.
StaticSolution Direct(Body body, int cells, const std::vector<LoadOptions>& loads) {
  const double side = 0.2 / cells;
  body.organ.lattice.cells = {cells, static_cast<int>(std::lround(0.7 * cells)),
                              static_cast<int>(std::lround(0.5 * cells))};
  body.organ.lattice.margin = 0.05 * side;
  const OrganModel model(body.organ, body.rest);
  return StaticLoads(model, loads).Solve();
}

TEST(FineLattices, AgreeWithTheDirectSolutionOfTheSameCells) {
  // nu 0.45: with projected dilatation; 0.3: without.
  for (const double poisson : {0.45, 0.3}) {
    Body body = HeldEllipsoid();
    body.organ.material.poisson = poisson;
    const std::vector<LoadOptions> loads = {PressOnTop({0.1, 0, -0.5})};
    const FineLattice lattice(body.organ, body.rest, 8);
    const StaticSolution direct = Direct(body, 8, loads);
    EXPECT_EQ(lattice.control_points(), direct.control_displacements.rows());
    // Conjugate gradients to 3e-4.
    EXPECT_LT(RelativeSurfaceError(body.rest, lattice.Displacements({loads})[0],
                                   direct.vertex_displacements),
              1e-3);
  }
}

// A block of 80 x 20 x 40 mm with a slit of 4 mm from above, held below.
Body HeldSlit() {
  Body body;
  body.rest = Joined(Joined(MakeBox({-0.04, -0.01, -0.02}, {-0.002, 0.01, 0.02}),
                            MakeBox({0.002, -0.01, -0.02}, {0.04, 0.01, 0.02})),
                     MakeBox({-0.04, -0.01, -0.025}, {0.04, 0.01, -0.01}));
  body.organ.name = "block";
  body.organ.lattice.local.functions = 0;
  body.organ.supports = {{BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.25)}, std::nullopt}};
  return body;
}

TEST(FineLattices, SplitFunctionsByTissueAsTheLatticesDo) {
  const Body body = HeldSlit();
  LoadOptions pull;
  pull.p_centre_W = {0.015, 0, 0.02};
  pull.radius = 0.008;
  pull.force_W = Vector3d(0.02, 0, 0);
  const FineLattice lattice(body.organ, body.rest, 8);
  ASSERT_TRUE(lattice.split());
  OrganOptions options = body.organ;
  options.lattice.cells = {8, 2, 5};
  options.lattice.margin = 0.05 * 0.08 / 8;
  const OrganModel direct(options, body.rest);
  ASSERT_TRUE(direct.HasSplitFunctions());
  EXPECT_EQ(lattice.control_points(), direct.control_points());
  const Points u = lattice.Displacements({{pull}})[0];
  // Conjugate gradients to 3e-4; the two strips in the slit do not have the same triangles.
  EXPECT_LT(
      RelativeSurfaceError(body.rest, u, StaticLoads(direct, {pull}).Solve().vertex_displacements),
      3e-3);
  // The other side of the slit is left alone.
  for (Eigen::Index v = 0; v < u.rows(); ++v) {
    if (body.rest.vertices(v, 2) < 0.019 || body.rest.vertices(v, 0) >= 0) continue;
    EXPECT_LT(u.row(v).norm() / u.rowwise().norm().maxCoeff(), 0.1);
  }
}

TEST(FineLattices, MeetDisplacementsAndForcesTogether) {
  const Body body = HeldEllipsoid();
  LoadOptions moved = PressOnTop(Vector3d::Zero());
  moved.force_W.reset();
  moved.p_centre_W = {0.1, 0, 0};
  moved.displacement_W = Vector3d(0, 0, 0.01);
  const std::vector<LoadOptions> loads = {PressOnTop({0, 0, -0.5}), moved};
  const Points u = FineLattice(body.organ, body.rest, 8).Displacements({loads})[0];
  EXPECT_LT(RelativeSurfaceError(body.rest, u, Direct(body, 8, loads).vertex_displacements), 1e-3);
}

TEST(FineLattices, SolveEachOfManyCasesAsIfItWereAlone) {
  const Body body = HeldEllipsoid();
  const FineLattice lattice(body.organ, body.rest, 6);
  std::vector<std::vector<LoadOptions>> cases;
  for (int i = 0; i < 6; ++i) cases.push_back({PressOnTop({0.1 * i, 0, -0.5})});
  const std::vector<Points> together = lattice.Displacements(cases);
  ASSERT_EQ(together.size(), cases.size());
  for (std::size_t i = 0; i < cases.size(); ++i) {
    EXPECT_EQ(together[i], lattice.Displacements({cases[i]})[0]) << i;
  }
}

TEST(FineLattices, HoldWhatSpringsHold) {
  Body body = HeldEllipsoid();
  body.organ.supports[0].stiffness = 1e6;
  const std::vector<LoadOptions> loads = {PressOnTop({0, 0, -0.5})};
  const Points u = FineLattice(body.organ, body.rest, 6).Displacements({loads})[0];
  EXPECT_LT(RelativeSurfaceError(body.rest, u, Direct(body, 6, loads).vertex_displacements), 1e-3);
}

TEST(FineLattices, RefusePressuresAndLoadsThatTouchNothing) {
  const Body body = HeldEllipsoid();
  const FineLattice lattice(body.organ, body.rest, 4);
  LoadOptions pressure;
  pressure.pressure = 10;
  EXPECT_THROW(lattice.Displacements({{pressure}}), InputError);
  LoadOptions beside = PressOnTop({0, 0, -1});
  beside.p_centre_W = {0, 0, 1};
  EXPECT_THROW(lattice.Displacements({{beside}}), InputError);
}

}  // namespace
}  // namespace hpdm
