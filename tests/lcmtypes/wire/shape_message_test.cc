#include <gtest/gtest.h>

#include <cmath>

#include "engine/deformation_loop.h"
#include "lcmtypes/wire/codec.h"
#include "lcmtypes/wire/logged_surface.h"
#include "lcmtypes/wire/mesh_codec.h"
#include "tests/support/shapes.h"
#include "tools/shared/one_organ.h"

/// The logged messages of an organ are enough to draw it.

namespace hpdm {
namespace {

OrganOptions Options() {
  OrganOptions options;
  options.name = "ellipsoid";
  options.energy.type = EnergyType::kStrain;
  options.lattice.cells = {3, 4, 5};
  options.lattice.local.functions = 20;
  options.supports.push_back({BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.25)}, {}});
  return options;
}

TEST(ShapeMessages, AViewerRebuildsTheSurfaceFromThem) {
  const std::vector<OrganModel> models =
      OneOrgan(Options(), Ellipsoid(Vector3d(0.1, 0.07, 0.05), 3));
  TripleBuffer<ToolState> tools;
  TripleBuffer<ContactPatch> patch;
  TripleBuffer<SceneSnapshot> render{SizedSnapshot(models, 1, true)},
      telemetry{SizedSnapshot(models, 1, false)};
  DeformationLoop loop(models, {ToolOptions()}, {tools, patch, render, telemetry});
  ToolState state;
  state.tool_count = 1;
  for (const double z : {0.055, 0.050, 0.047}) {
    ++state.tick;
    state.tools[0].X_WT.translation() = Vector3d(0.02, 0.01, z);
    state.tools[0].p_trocar_W = Vector3d(0.02, 0.01, 0.3);
    loop.Step(state, 0);
  }
  render.Update();
  telemetry.Update();
  const Points shown = render.Front().organs[0].vertices.cast<double>();

  const Lattice& lattice = models[0].lattice_organ()->lattice();
  OrganDescription sent{"ellipsoid", models[0].rest().vertices, models[0].rest().triangles, {}};
  sent.lattice = LatticeDescription{.degree = {2, 2, 2},
                                    .cells = {3, 4, 5},
                                    .origin_W = lattice.box().origin_W,
                                    .axes = lattice.box().axes,
                                    .lengths = lattice.box().lengths,
                                    .kept = lattice.kept(),
                                    .local_refinement = 2};
  OrganDescription organ;
  std::string error;
  ASSERT_TRUE(JoinMesh(SplitMesh(0, sent), &organ, &error)) << error;
  organ_t message{};
  ToMessage(StepRecord(), 0, telemetry.Front().organs[0], &message);
  OrganSnapshot shape;
  ASSERT_TRUE(FromMessage(message, &shape));

  EXPECT_GT(shape.local_functions.size(), 0u);
  EXPECT_EQ(shape.indentation_count, 1);
  const Points moved = shown - models[0].rest().vertices;
  EXPECT_GT(moved.rowwise().norm().maxCoeff(), 1e-4);
  // Floats of positions up to 0.1 m.
  const LoggedSurface surface(organ);
  Points rebuilt;
  ASSERT_TRUE(surface.Deform(shape, &rebuilt));
  EXPECT_LT((rebuilt - shown).cwiseAbs().maxCoeff(), 1e-7);
  // Without the indentation it would not be the same surface.
  shape.indentation_count = 0;
  ASSERT_TRUE(surface.Deform(shape, &rebuilt));
  EXPECT_GT((rebuilt - shown).cwiseAbs().maxCoeff(), 1e-6);
  // A shape of another organ.
  const OrganSnapshot sound = shape;
  shape.local_functions[0] = 1'000'000;
  EXPECT_FALSE(surface.Deform(shape, &rebuilt));
  shape = sound;
  shape.control_displacements.conservativeResize(shape.control_displacements.rows() - 1, 3);
  EXPECT_FALSE(surface.Deform(shape, &rebuilt));
  shape = sound;
  shape.control_displacements(0, 0) = std::nan("");
  EXPECT_FALSE(surface.Deform(shape, &rebuilt));
}

}  // namespace
}  // namespace hpdm
