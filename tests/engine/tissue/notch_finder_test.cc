#include "engine/tissue/notch_finder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "engine/lattice/cut_surface.h"
#include "engine/lattice/lattice.h"
#include "engine/organ.h"
#include "engine/statics/static_loads.h"
#include "tests/support/mesh_shapes.h"
#include "tests/support/shapes.h"

/// Gaps between the walls of one organ, found on its surface.

namespace hpdm {
namespace {

constexpr double kCell = 0.01;

/// A block of 80 x 20 x 50 mm with a slit from above, `width` wide, down to z = `end` (m).
SurfaceMesh SlitBlock(double width, double end) {
  return Joined(Joined(MakeBox({-0.04, -0.01, end - 0.005}, {-width / 2, 0.01, 0.02}),
                       MakeBox({width / 2, -0.01, end - 0.005}, {0.04, 0.01, 0.02})),
                MakeBox({-0.04, -0.01, -0.03}, {0.04, 0.01, end}));
}

SurfaceMesh Moved(SurfaceMesh mesh, const Isometry3d& X, double scale = 1) {
  mesh.vertices =
      (scale * mesh.vertices * X.linear().transpose()).rowwise() + X.translation().transpose();
  return mesh;
}

TEST(Notches, EndInACutWhoseFrontLiesJustBelowTheGapsEnd) {
  for (const double width : {0.0005, 0.002, 0.009}) {
    const std::vector<CutOptions> notches = FindNotches(SlitBlock(width, -0.01), "block", kCell);
    ASSERT_EQ(notches.size(), 1u) << width;
    double low = 1, high = -1;
    for (const BladeEdge& edge : notches[0].strip) {
      EXPECT_NEAR(edge.a.x(), 0, 1e-9);
      EXPECT_NEAR(edge.a.z(), -0.01 - 0.07 * width, 1e-7) << width;
      EXPECT_GT(edge.b.z(), 0) << width;
      low = std::min(low, edge.a.y());
      high = std::max(high, edge.a.y());
    }
    // It spans the block, whose sides are 20 mm apart.
    EXPECT_LT(low, -0.01);
    EXPECT_GT(high, 0.01);
  }
}

TEST(Notches, DoNotDependOnPoseOrUnit) {
  const SurfaceMesh block = SlitBlock(0.002, -0.01);
  const std::vector<CutOptions> plain = FindNotches(block, "block", kCell);
  ASSERT_EQ(plain.size(), 1u);
  for (const double scale : {1.0, 0.01, 100.0}) {
    const Isometry3d X = SomePose();
    const std::vector<CutOptions> moved =
        FindNotches(Moved(block, X, scale), "block", scale * kCell);
    ASSERT_EQ(moved.size(), 1u) << scale;
    for (const BladeEdge& edge : moved[0].strip) {
      const Vector3d a = X.inverse() * edge.a / scale;
      EXPECT_NEAR(a.x(), 0, 1e-6);
      EXPECT_NEAR(a.z(), plain[0].strip[0].a.z(), 1e-4) << scale;
    }
  }
}

TEST(Notches, AreNarrowDeepAndEndInTissue) {
  // A gap of three cells, a groove of 4 mm depth, two blocks that nothing joins, a closed hollow.
  EXPECT_TRUE(FindNotches(SlitBlock(0.03, -0.01), "block", kCell).empty());
  EXPECT_TRUE(FindNotches(SlitBlock(0.002, 0.016), "block", kCell).empty());
  EXPECT_TRUE(FindNotches(Joined(MakeBox({-0.04, -0.01, -0.02}, {-0.001, 0.01, 0.02}),
                                 MakeBox({0.001, -0.01, -0.02}, {0.04, 0.01, 0.02})),
                          "blocks", kCell)
                  .empty());
  EXPECT_TRUE(FindNotches(Joined(MakeBox({-0.04, -0.03, -0.02}, {0.04, 0.03, 0.02}),
                                 Reversed(MakeBox({-0.03, -0.02, -0.002}, {0.03, 0.02, 0.002}))),
                          "hollow", kCell)
                  .empty());
  EXPECT_TRUE(FindNotches(Ellipsoid({0.1, 0.07, 0.05}, 3), "ellipsoid", kCell).empty());
}

OrganOptions HeldBelow() {
  OrganOptions organ;
  organ.name = "block";
  organ.lattice.local.functions = 0;
  organ.lattice.cells = {8, 2, 5};
  organ.lattice.margin = 0.001;
  organ.energy.type = EnergyType::kStrain;
  organ.supports = {{BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.1)}, std::nullopt}};
  return organ;
}

/// Opens a gap and returns by how much (m).
double Opening(const OrganOptions& organ, const SurfaceMesh& mesh) {
  const OrganModel model(organ, mesh);
  std::vector<LoadOptions> pulls(2);
  for (const int side : {0, 1}) {
    LoadOptions& pull = pulls[static_cast<std::size_t>(side)];
    pull.p_centre_W = {side == 0 ? 0.015 : -0.015, 0, 0.02};
    pull.radius = 0.008;
    pull.force_W = Vector3d(side == 0 ? 0.02 : -0.02, 0, 0);
  }
  const Points u = StaticLoads(model, pulls).Solve().vertex_displacements;
  return u.col(0).maxCoeff() - u.col(0).minCoeff();
}

// The answer of the same block with a wider slit, which the lattice sees without help, is close to
// that with a narrow one.
TEST(Notches, LetAGapOpenThatIsFarNarrowerThanVoxelsAndCells) {
  OrganOptions organ = HeldBelow();
  const double wide = Opening(organ, SlitBlock(0.004, -0.01));
  EXPECT_NEAR(Opening(organ, SlitBlock(0.0001, -0.01)) / wide, 1, 0.08);
  organ.lattice.notch_functions = false;
  EXPECT_LT(Opening(organ, SlitBlock(0.0001, -0.01)), 0.7 * wide);
}

TEST(Notches, GetFunctionsOfAFrontOnlyWhereTheModelTakesThem) {
  const SurfaceMesh block = SlitBlock(0.002, -0.01);
  OrganOptions organ = HeldBelow();
  EXPECT_GT(OrganModel(organ, block).lattice_organ()->lattice().front_functions(), 0);
  EXPECT_TRUE(OrganModel(organ, block).HasSplitFunctions());
  organ.energy.strain = StrainMeasure::kFinite;
  EXPECT_EQ(OrganModel(organ, block).lattice_organ()->lattice().front_functions(), 0);
}

}  // namespace
}  // namespace hpdm
