#include "engine/organ.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "tests/support/deformation_loop_fixture.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

TEST(LocalFunctionsOfAnOrgan, DefaultToTwentySevenWhereTheModelSupportsThem) {
  OrganOptions organ;
  EXPECT_EQ(organ.energy.type, EnergyType::kStrain);
  EXPECT_EQ(LocalFunctionsOf(organ), 27);
  for (const StrainMeasure strain : {StrainMeasure::kFinite, StrainMeasure::kAdaptive}) {
    organ.energy.strain = strain;
    EXPECT_EQ(LocalFunctionsOf(organ), 27);
  }
  for (const int given : {0, 5}) {
    organ.lattice.local.functions = given;
    EXPECT_EQ(LocalFunctionsOf(organ), given);
  }
  std::vector<OrganOptions> without(7);
  without[0].energy.type = EnergyType::kMetric;
  without[1].energy.solver = SolverType::kGaussSeidel;
  without[2].lattice.basis = BasisType::kBernstein;
  without[3].model = OrganModelType::kContinuum;
  without[4].model = OrganModelType::kMassSpring;
  without[5].model = OrganModelType::kRigid;
  without[6].lattice.cells = {51, 50, 50};  // of half the size, more than a million
  for (std::size_t i = 0; i < without.size(); ++i) EXPECT_EQ(LocalFunctionsOf(without[i]), 0) << i;
}

TEST(LocalFunctionsOfAnOrgan, AreRefusedIfGivenToAModelThatCannotHaveThem) {
  const SurfaceMesh rest = Ellipsoid(Vector3d(0.1, 0.07, 0.05), 2);
  OrganOptions organ;
  organ.name = "ellipsoid";
  organ.lattice.cells = {2, 2, 2};
  organ.supports = {{BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.25)}, {}}};
  const OrganModel refined(organ, rest);
  EXPECT_NE(refined.refinement_basis(), nullptr);
  EXPECT_EQ(refined.RefinementSlots(2), 54);
  organ.energy.type = EnergyType::kMetric;
  EXPECT_EQ(OrganModel(organ, rest).RefinementSlots(2), 0);
  organ.lattice.local.functions = 5;
  EXPECT_THROW(OrganModel(organ, rest), InputError);
}

TEST(OrganModel, BuildsTheEnergyOfItsOptions) {
  const SurfaceMesh mesh = Ellipsoid(Vector3d(0.1, 0.07, 0.05), 3);
  const Vector3d push(0, 0, -1e-5);
  std::vector<double> forces;
  for (const StrainMeasure strain : {StrainMeasure::kSmall, StrainMeasure::kFinite}) {
    OrganOptions options;
    options.energy.type = EnergyType::kStrain;
    options.energy.strain = strain;
    options.lattice.local.functions = 0;
    options.material.poisson = 0;  // the dilatation's form does not matter
    SupportOptions bottom;
    bottom.region = BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.25)};
    options.supports.push_back(bottom);
    const OrganModel model(options, mesh);
    OrganState state(model, 1);
    Eigen::Index top = 0;
    mesh.vertices.col(2).maxCoeff(&top);
    ContactConstraints::Row* row = state.contacts.Add();
    row->p_rest_W = mesh.vertices.row(top);
    row->target_W = row->p_rest_W + push;
    state.contacts.WeightRow(0) = model.weights().row(top).toDense();
    Points U = Points::Zero(model.control_points(), 3);
    EXPECT_TRUE(state.relaxation->Relax(&state.contacts, &U).converged);
    forces.push_back(state.contacts[0].force_W.norm());
    EXPECT_GT(forces.back(), 0);
  }
  // Strain of about 1e-5 / 0.02 m; the fewer points of finite strain make 0.16 %.
  EXPECT_NEAR(forces[1] / forces[0], 1, 3e-3);
}

TEST(OrganModel, SupportOutsideTheTissueIsRefused) {
  OrganOptions options = PressedEllipsoidOptions();
  options.supports[0].region = Sphere{Vector3d(1, 1, 1), 0.01};
  EXPECT_THROW(OrganModel(options, Ellipsoid(Vector3d(0.1, 0.07, 0.05), 2)), InputError);
}

// Splines and corner weights reproduce affine fields.
TEST(OrganModel, ASurfacePointsRowReproducesAffineDisplacements) {
  const OrganModel model(PressedEllipsoidOptions(), Ellipsoid(Vector3d(0.1, 0.07, 0.05), 2));
  Matrix3d A;
  A << 0.1, -0.2, 0.05, 0.3, 0.02, -0.1, 0, 0.15, -0.25;
  const Points U = model.lattice_organ()->lattice().ControlPoints() * A.transpose();
  const ActiveRefinement none(0, 0);
  for (int t = 0; t < model.rest().triangles.rows(); t += 7) {
    const SurfacePoint at{.triangle = t, .barycentric = Vector3d(0.2, 0.5, 0.3)};
    Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(model.control_points());
    model.AddToRow(at, 2, none, row);
    const Vector3d p = at.Position(model.rest().vertices, model.rest().triangles);
    EXPECT_LT(((row * U).transpose() - 2 * A * p).norm(), 1e-14) << t;  // round-off
  }
}

TEST(LoadPosedMesh, TheUnitComesBeforeThePose) {
  const ScratchFolder folder;
  OrganOptions options;
  options.mesh = folder / "tetrahedron.obj";
  std::ofstream(options.mesh) << "v 0 0 0\nv 0 40 0\nv 30 0 0\nv 0 0 50\n"
                                 "f 1 2 3\nf 1 3 4\nf 1 4 2\nf 2 4 3\n";
  options.unit_m = 1e-3;
  options.X_WO =
      Eigen::Translation3d(0.1, 0.2, 0.3) * Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitZ());
  std::vector<std::string> repairs;
  const SurfaceMesh mesh = LoadPosedMesh(options, &repairs);
  EXPECT_TRUE(repairs.empty());
  Points expected(4, 3);  // x goes to y, and y to -x
  expected << 0.1, 0.2, 0.3, 0.06, 0.2, 0.3, 0.1, 0.23, 0.3, 0.1, 0.2, 0.35;
  ASSERT_EQ(mesh.vertices.rows(), 4);
  EXPECT_LT((mesh.vertices - expected).norm(), 1e-15);  // round-off
}

TEST(LoadPosedMesh, RefusesAFileInMillimetresTakenForMetres) {
  const ScratchFolder folder;
  OrganOptions options;
  options.name = "liver";
  options.mesh = folder / "tetrahedron.obj";
  std::ofstream(options.mesh) << "v 0 0 0\nv 0 200 0\nv 150 0 0\nv 0 0 100\n"
                                 "f 1 2 3\nf 1 3 4\nf 1 4 2\nf 2 4 3\n";
  std::vector<std::string> repairs;
  try {
    LoadPosedMesh(options, &repairs);
    FAIL() << "an organ of 200 m was loaded";
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()),
              options.mesh +
                  ": organ \"liver\": 200 m across, 5e+05 m^3; an organ is 0.001 to 2 m across and "
                  "at most 0.1 m^3; set organ.unit = \"mm\"");
  }
  options.unit_m = 1e-3;
  EXPECT_EQ(LoadPosedMesh(options, &repairs).vertices.maxCoeff(), 0.2);
}

}  // namespace
}  // namespace hpdm
