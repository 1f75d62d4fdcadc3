#include <gtest/gtest.h>

#include "engine/baselines/surface_error.h"
#include "engine/organ/organ_state.h"
#include "engine/statics/static_loads.h"
#include "tests/support/shapes.h"

/// A body in another unit, with its loads, takes the same shape: no tolerance, regularisation or
/// determinant is compared with a number that has a unit.
namespace hpdm {
namespace {

struct Unit {
  double length, modulus;
};

OrganOptions Options(const Unit& unit) {
  OrganOptions options;
  options.name = "ellipsoid";
  options.lattice.cells = {3, 3, 3};
  options.lattice.local.functions = 0;
  options.lattice.margin = 0.01 * unit.length;
  options.material.young *= unit.modulus;
  options.energy.alpha *= unit.modulus;
  options.energy.beta *= unit.modulus * unit.length * unit.length;
  options.supports = {{BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.27)}, {}}};
  return options;
}

SurfaceMesh ScaledBody(const Unit& unit) {
  return Ellipsoid(unit.length * Vector3d(0.1, 0.07, 0.05), 3);
}

// Returns displacements over the unit of length: in equilibrium under a force, and after three
// real-time steps under a press and a grasp that oppose each other.
std::vector<Points> Shapes(const OrganOptions& options, const Unit& unit) {
  const OrganModel organ(options, ScaledBody(unit));
  LoadOptions load;
  load.organ = "ellipsoid";
  load.p_centre_W = unit.length * Vector3d(0.01, 0.005, 0.0494);
  load.radius = 0.015 * unit.length;
  load.force_W = unit.modulus * unit.length * unit.length * Vector3d(0.1, 0, -0.4);
  std::vector<Points> shapes = {StaticLoads(organ, {load}).Solve().vertex_displacements};

  OrganState state(organ, 2);
  for (int step = 0; step < 3; ++step) {
    state.contacts.Clear();
    for (const bool grasps : {false, true}) {
      ContactConstraints::Row* row = state.contacts.Add();
      row->kind =
          grasps ? ContactConstraints::RowKind::kGrasp : ContactConstraints::RowKind::kPress;
      row->p_rest_W = unit.length * Vector3d(grasps ? 0.02 : -0.01, 0.005, 0.049);
      row->target_W = row->p_rest_W + unit.length * Vector3d(0.003, 0, grasps ? 0.006 : -0.006);
      row->indentation = organ.AddLoadToRow(row->p_rest_W, load.radius, state.contacts.refinement,
                                            state.contacts.WeightRow(state.contacts.size() - 1));
      if (grasps) row->local_compliance_W = row->indentation.Compliance();
    }
    state.relaxation->Relax(&state.contacts, &state.control_displacements);
  }
  shapes.emplace_back(organ.rest().vertices.rows(), 3);
  organ.relocation().Displace(state.control_displacements, &shapes.back());
  for (Points& shape : shapes) shape /= unit.length;
  return shapes;
}

struct ScaledModel {
  const char* name;
  EnergyType type;
  StrainMeasure strain;
  SolverType solver;
};

class RescaledBodyTest : public testing::TestWithParam<ScaledModel> {};
INSTANTIATE_TEST_SUITE_P(
    Models, RescaledBodyTest,
    testing::Values(
        ScaledModel{"strain", EnergyType::kStrain, StrainMeasure::kSmall, SolverType::kCholesky},
        ScaledModel{"strain_sweeps", EnergyType::kStrain, StrainMeasure::kSmall,
                    SolverType::kGaussSeidel},
        ScaledModel{"strain_finite", EnergyType::kStrain, StrainMeasure::kFinite,
                    SolverType::kCholesky},
        ScaledModel{"metric", EnergyType::kMetric, StrainMeasure::kSmall, SolverType::kCholesky},
        ScaledModel{"metric_sweeps", EnergyType::kMetric, StrainMeasure::kSmall,
                    SolverType::kGaussSeidel},
        ScaledModel{"metric_finite", EnergyType::kMetric, StrainMeasure::kFinite,
                    SolverType::kCholesky}),
    [](const auto& model) { return model.param.name; });

TEST_P(RescaledBodyTest, TakesTheSameShapeInAnyUnit) {
  const auto options = [](const Unit& unit) {
    OrganOptions made = Options(unit);
    made.energy.type = GetParam().type;
    made.energy.strain = GetParam().strain;
    made.energy.solver = GetParam().solver;
    return made;
  };
  const std::vector<Points> shapes = Shapes(options({1, 1}), {1, 1});
  const SurfaceMesh rest = ScaledBody({1, 1});
  // Round-off, times the condition of the stiffness; 1e-6 is what anyone could notice. The iterations
  // of finite strain end before round-off does, on a way that it turns (0.35 % measured).
  const double tolerance = GetParam().strain == StrainMeasure::kSmall ? 1e-9 : 5e-3;
  for (const Unit& unit : {Unit{1e3, 1}, Unit{1e-3, 1}, Unit{1, 1e6}, Unit{1, 1e-6}}) {
    SCOPED_TRACE(testing::Message()
                 << unit.length << " x length, " << unit.modulus << " x modulus");
    const std::vector<Points> others = Shapes(options(unit), unit);
    for (std::size_t s = 0; s < shapes.size(); ++s) {
      EXPECT_LT(RelativeSurfaceError(rest, others[s], shapes[s]), tolerance);
    }
  }
}

}  // namespace
}  // namespace hpdm
