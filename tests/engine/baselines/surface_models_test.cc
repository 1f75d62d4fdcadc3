#include <gtest/gtest.h>

#include "engine/base/error.h"
#include "engine/deformation_loop.h"
#include "engine/statics/static_loads.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

// The surface models as scenes use them: an ellipsoid of 0.1 x 0.07 x 0.05 m half-axes held in its
// lower part.
class SurfaceModelsTest : public testing::TestWithParam<OrganModelType> {
 protected:
  static OrganOptions Options() {
    OrganOptions options;
    options.name = "ellipsoid";
    options.model = GetParam();
    options.supports.push_back({BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.25)}, {}});
    return options;
  }
  SurfaceModelsTest() { models_.emplace_back(Options(), Ellipsoid(Vector3d(0.1, 0.07, 0.05), 2)); }
  const SurfaceMesh& Rest() const { return models_[0].rest(); }
  static LoadOptions Load(const Vector3d& p) {
    LoadOptions load;
    load.organ = "ellipsoid";
    load.p_centre_W = p;
    load.radius = 0.02;
    return load;
  }
  std::vector<OrganModel> models_;
};
INSTANTIATE_TEST_SUITE_P(Models, SurfaceModelsTest,
                         testing::Values(OrganModelType::kContinuum, OrganModelType::kMassSpring));

TEST_P(SurfaceModelsTest, EveryVertexIsAControlPoint) {
  EXPECT_EQ(models_[0].lattice_organ(), nullptr);
  EXPECT_EQ(models_[0].control_points(), Rest().vertices.rows());
  EXPECT_NEAR(models_[0].tissue_volume(), EnclosedVolume(Rest().vertices, Rest().triangles), 0);
  // The ellipsoid is symmetric about the origin; round-off.
  EXPECT_LT(models_[0].centre_of_volume_W().norm(), 1e-12);
}

TEST_P(SurfaceModelsTest, PressDentsTheOrganPushesBackAndRecovers) {
  TripleBuffer<ToolState> tools;
  TripleBuffer<ContactPatch> patch;
  TripleBuffer<SceneSnapshot> render{SizedSnapshot(models_, 1, true)};
  TripleBuffer<SceneSnapshot> telemetry{SizedSnapshot(models_, 1, false)};
  DeformationLoop loop(models_, {ToolOptions()}, {tools, patch, render, telemetry});
  ToolState state;
  state.tool_count = 1;
  const auto step = [&](double z) {
    ++state.tick;
    state.tools[0].X_WT.translation() = Vector3d(0.012, 0.005, z);
    state.tools[0].p_trocar_W = Vector3d(0.012, 0.005, z + 0.2);
    loop.Step(state, 0);
    patch.Update();
    render.Update();
  };
  for (double z = 0.055; z > 0.04; z -= 0.001) step(z);
  for (int i = 0; i < 30; ++i) step(0.04);
  const double dent = (loop.organ(0).vertices - Rest().vertices).rowwise().norm().maxCoeff();
  EXPECT_GT(dent, 0.005);  // the tip's lowest point is about 12 mm below the surface
  EXPECT_LT(patch.Front().tools[0].main().force_on_tissue_W.z(), -0.01);
  EXPECT_EQ(loop.record().flags, static_cast<std::uint32_t>(kStepOk));
  EXPECT_EQ(render.Front().organs[0].vertices, loop.organ(0).vertices.cast<float>());
  for (int i = 0; i < 300; ++i) step(0.2);
  // 10 s are 100 times 2 / damping.
  EXPECT_LT((loop.organ(0).vertices - Rest().vertices).rowwise().norm().maxCoeff(), 0.02 * dent);
}

TEST_P(SurfaceModelsTest, StaticLoadsAreBalancedAndHeldPatchesReachTheirPlaces) {
  LoadOptions by_force = Load(Vector3d(0.01, 0.005, 0.0494));
  by_force.force_W = Vector3d(0, 0.01, -0.05);
  const StaticLoads pressed(models_[0], {by_force});
  const StaticSolution press = pressed.Solve();
  EXPECT_LT(pressed.Residual(press), 1e-6);  // Newton's tolerance is 1e-8
  EXPECT_GT(press.Compliance(), 0);

  LoadOptions by_displacement = Load(by_force.p_centre_W);
  by_displacement.displacement_W = press.load_displacements[0];
  const StaticSolution held = StaticLoads(models_[0], {by_displacement}).Solve();
  EXPECT_LT((held.load_displacements[0] - press.load_displacements[0]).norm(),
            1e-6 * press.load_displacements[0].norm());
  EXPECT_LT((held.load_forces[0] - *by_force.force_W).norm(), 1e-4 * by_force.force_W->norm());
}

TEST_P(SurfaceModelsTest, OpenSurfaceIsRefused) {
  SurfaceMesh inside_out = Rest();
  inside_out.triangles.col(0).swap(inside_out.triangles.col(1));
  EXPECT_THROW(OrganModel(Options(), inside_out), InputError);
}

}  // namespace
}  // namespace hpdm
