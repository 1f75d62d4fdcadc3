#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "engine/organ.h"
#include "engine/statics/static_loads.h"
#include "tests/support/deformation_loop_fixture.h"
#include "tests/support/mesh_shapes.h"
#include "tests/support/shapes.h"

/// Functions of finer levels, placed by an estimate of the error (engine/organ/level_placement.h).

namespace hpdm {
namespace {

/// A bar of 120 x 30 x 30 mm, held at its left end and pulled up at a patch of its right end.
struct Bar {
  explicit Bar(double poisson = 0.3) : rest(MakeBox({0, 0, 0}, {0.12, 0.03, 0.03})) {
    organ.name = "bar";
    organ.material.poisson = poisson;
    organ.lattice.cells = {6, 2, 2};
    organ.lattice.margin = 0.001;
    organ.lattice.local.functions = 0;
    organ.supports = {{Box{{-0.01, -0.01, -0.01}, {0.01, 0.04, 0.04}},
                       1e9}};  // the same springs for all lattices
    LoadOptions pull;
    pull.organ = organ.name;
    pull.p_centre_W = Vector3d(0.1, 0.015, 0.03);
    pull.radius = 0.014;
    pull.force_W = Vector3d(0, 0, 0.02);
    organ.loads = {pull};
  }
  OrganModel Model(int factor, int functions, int levels) const {
    OrganOptions options = organ;
    for (int& cells : options.lattice.cells) cells *= factor;
    options.lattice.adaptive = {functions, levels};
    return {options, rest};
  }
  double Compliance(const OrganModel& model) const {
    return StaticLoads(model, organ.loads).Solve().Compliance();
  }
  SurfaceMesh rest;
  OrganOptions organ;
};

// The second way is the uniform lattice with the cells of the finest level.
TEST(LevelPlacement, WithAllFunctionsGivesTheUniformLatticesShape) {
  for (const double poisson : {0.0, 0.45}) {
    const Bar bar(poisson);
    const OrganModel coarse = bar.Model(1, 0, 1), uniform = bar.Model(2, 0, 1),
                     levels = bar.Model(1, 2000, 1);
    // The finest level spans all others, so no more functions than it has are independent.
    EXPECT_LE(levels.control_points(), uniform.control_points());
    EXPECT_GT(levels.control_points(), 0.8 * uniform.control_points());
    const double expected = bar.Compliance(uniform);
    EXPECT_GT(std::abs(bar.Compliance(coarse) / expected - 1), 0.02) << "the case tells them apart";
    EXPECT_NEAR(bar.Compliance(levels) / expected, 1, 0.004) << poisson;
  }
}

TEST(LevelPlacement, AddsAsManyFunctionsAsAreWantedAndKeepsTheUniformLattice) {
  const Bar bar;
  const OrganModel plain = bar.Model(1, 0, 2);
  const int n = plain.control_points();
  EXPECT_FALSE(plain.HasSplitFunctions());
  EXPECT_FALSE(plain.lattice_organ()->error_of_levels().has_value());
  for (const int wanted : {n + 1, n + 40, n + 160}) {
    const OrganModel model = bar.Model(1, wanted, 2);
    EXPECT_EQ(model.control_points(), wanted);
    EXPECT_TRUE(model.HasSplitFunctions());
    EXPECT_EQ(model.lattice_organ()->lattice().kept(), plain.lattice_organ()->lattice().kept());
    EXPECT_TRUE(Eigen::MatrixXd(model.weights()).leftCols(n) == Eigen::MatrixXd(plain.weights()));
  }
  EXPECT_EQ(bar.Model(1, n / 2, 2).control_points(), n);
}

// The energy that finer functions gain is known from the compliances: E = f . u.
TEST(LevelPlacement, TheEstimateIsTheEnergyThatTheFinerLatticeGains) {
  for (const double poisson : {0.0, 0.3}) {
    const Bar bar(poisson);
    const OrganModel coarse = bar.Model(1, 1, 1);
    const double gained = bar.Compliance(bar.Model(2, 0, 1)) / bar.Compliance(coarse) - 1;
    const double estimate = coarse.lattice_organ()->error_of_levels().value();
    EXPECT_LT(estimate, 1.3 * std::sqrt(gained)) << poisson;  // its points are few: 21 % seen
    EXPECT_GT(estimate, 0.6 * std::sqrt(gained)) << poisson;
  }
}

TEST(LevelPlacement, TheEstimateFallsAsFunctionsAreAdded) {
  const Bar bar(0.45);
  const int n = bar.Model(1, 0, 1).control_points();
  double last = 1;
  for (const int more : {1, 60, 200, 500}) {
    const double error = bar.Model(1, n + more, 2).lattice_organ()->error_of_levels().value();
    EXPECT_LT(error, last);
    last = error;
  }
  EXPECT_LT(last, 0.15);
}

// Half of the functions that a uniform lattice needs.
TEST(LevelPlacement, NeedsFewerFunctionsThanAUniformLatticeForItsError) {
  const Bar bar(0.3);
  const OrganModel finest = bar.Model(3, 0, 1), uniform = bar.Model(2, 0, 1);
  const double exact = bar.Compliance(finest);
  const OrganModel placed = bar.Model(1, uniform.control_points() / 2, 2);
  EXPECT_LT(std::abs(bar.Compliance(placed) / exact - 1),
            std::abs(bar.Compliance(uniform) / exact - 1));
}

// Without loads, functions follow presses all over the surface; with finite strain and sessions as
// with small strain.
TEST(LevelPlacement, ServesSessionsWithoutLoads) {
  for (const StrainMeasure strain : {StrainMeasure::kSmall, StrainMeasure::kFinite}) {
    for (const int local : {0, 27}) {
      OrganOptions options = PressedEllipsoidOptions();
      options.energy.type = EnergyType::kStrain;
      options.energy.strain = strain;
      options.lattice.local.functions = local;
      options.lattice.adaptive = {200, 1};
      const OrganModel model(options, Ellipsoid(Vector3d(0.1, 0.07, 0.05), 2));
      EXPECT_EQ(model.control_points(), 200);
      OrganState state(model, 1);
      Eigen::Index top = 0;
      model.rest().vertices.col(2).maxCoeff(&top);
      ContactConstraints::Row* row = state.contacts.Add();
      row->kind = ContactConstraints::RowKind::kGrasp;
      row->p_rest_W = model.rest().vertices.row(top);
      row->target_W = row->p_rest_W + Vector3d(0, 0, 1e-4);
      state.contacts.WeightRow(0).head(200) = model.weights().row(top).toDense();
      Points U = Points::Zero(200 + model.RefinementSlots(1), 3);
      EXPECT_TRUE(state.relaxation->Relax(&state.contacts, &U).converged);
      const Vector3d moved = (model.weights() * U.topRows(200)).row(top);
      EXPECT_LT((moved - Vector3d(0, 0, 1e-4)).norm(), 1e-8);
    }
  }
}

TEST(LevelPlacement, IsRefusedWhereItCannotBe) {
  const Bar bar;
  OrganOptions options = bar.organ;
  options.lattice.adaptive = {200, 1};
  const auto message = [&] {
    try {
      OrganModel(options, bar.rest);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  options.energy.type = EnergyType::kMetric;
  EXPECT_NE(message().find("adaptive functions need"), std::string::npos) << message();
  options.energy.type = EnergyType::kStrain;
  options.cuts = {{.organ = "bar",
                   .number = 0,
                   .strip = {{{0.05, -0.1, 0.02}, {0.05, 0.1, 0.02}},
                             {{0.05, -0.1, 0.05}, {0.05, 0.1, 0.05}}}}};
  EXPECT_NE(message().find("combined with cuts"), std::string::npos) << message();
  options.cuts.clear();
  options.supports.clear();
  options.free.emplace();
  EXPECT_NE(message().find("[organ.free]"), std::string::npos) << message();
}

}  // namespace
}  // namespace hpdm
