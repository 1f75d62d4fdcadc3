#include "tools/haptics/tip_accuracy.h"

#include "engine/base/error.h"
#include "engine/deformation_loop.h"
#include "haptics/contact/lattice_reaction.h"
#include "tools/session/contact_stiffness.h"

namespace hpdm {
namespace {

constexpr double kNear = 0.001;  // m: gap between the tip's surface and the tissue

}  // namespace

TipAccuracy MeasureTipAccuracy(const StaticCase& load_case, const CaseReference& reference,
                               int local_functions) {
  const std::string file = load_case.scene.path.string();
  const LoadOptions& load = load_case.scene.loads[0];
  if (load_case.scene.loads.size() != 1 || !load.force_W.has_value() ||
      reference.load_displacements.size() != 1) {
    throw InputError(file +
                     ": needs one force whose displacement the reference solution gives; choose "
                     "a case of one force");
  }
  OrganOptions organ = load_case.organ;
  organ.lattice.local.functions = local_functions;
  std::vector<OrganModel> organs;
  organs.emplace_back(organ, load_case.rest);
  const SurfaceMesh& rest = organs[0].rest();
  const SurfacePoint at =
      SurfaceTree(rest.vertices, rest.triangles).Closest(load.p_centre_W, 10 * load.radius).at;
  if (at.triangle < 0)
    throw InputError(file + ": no surface at the load's point; move the point to the surface");
  const Vector3d normal =
      InterpolatedNormal(rest.vertices, rest.triangles, organs[0].topology(), at);

  TripleBuffer<ToolState> tools;
  TripleBuffer<ContactPatch> patch;
  TripleBuffer<SceneSnapshot> render(SizedSnapshot(organs, 1, false));
  TripleBuffer<SceneSnapshot> telemetry(SizedSnapshot(organs, 1, false));
  DeformationLoop deformation(organs, {{.geometries = {{.tip_radius = load.radius}}}},
                              {tools, patch, render, telemetry});
  ToolState state;
  state.tool_count = 1;
  state.tools[0].X_WT.translation() =
      at.Position(rest.vertices, rest.triangles) + (load.radius + kNear) * normal;
  state.tools[0].p_trocar_W = state.tools[0].X_WT.translation() + 0.1 * normal;
  deformation.Step(state, 0);
  patch.Update();
  const ToolPatch& tip = patch.Front().tools[0].main();

  // The reference's load is a kernel.
  const Vector3d force =
      TipForce({.holds = true,
                .p_original_W = tip.p_original_W,
                .compliance_W = DeepCompliance(tip),
                .p_current_W = tip.p_original_W + reference.load_displacements[0]});
  const double given = load.force_W->norm();
  return {CaseName(load_case), local_functions, given, force.dot(*load.force_W) / given};
}

}  // namespace hpdm
