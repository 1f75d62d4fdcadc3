// Embeds the engine: presses a liver 10 mm deep and prints how it answers.
// Usage: embed MESH.obj (metres)
#include <cstdio>

#include "engine/deformation_loop.h"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  hpdm::OrganOptions options;
  options.name = "liver";
  options.mesh = argv[1];
  options.supports.push_back({.region = hpdm::BoxFraction{{0, 0, 0}, {1, 1, 0.3}}});
  std::vector<std::string> repairs;
  std::vector<hpdm::OrganModel> organs;
  organs.emplace_back(options, hpdm::LoadPosedMesh(options, &repairs));

  // The edges to the other threads; here one thread plays all parts.
  hpdm::TripleBuffer<hpdm::ToolState> tools;
  hpdm::TripleBuffer<hpdm::ContactPatch> patch;
  hpdm::TripleBuffer<hpdm::SceneSnapshot> view(hpdm::SizedSnapshot(organs, 1, true));
  hpdm::TripleBuffer<hpdm::SceneSnapshot> record(hpdm::SizedSnapshot(organs, 1, false));
  hpdm::DeformationLoop loop(organs, {hpdm::ToolOptions()}, {tools, patch, view, record});

  // The tip moves straight down from above the liver's centre.
  const double top = organs[0].rest().vertices.col(2).maxCoeff();
  for (double depth = -0.02; depth <= 0.01; depth += 0.002) {
    hpdm::ToolState& state = tools.Back();
    state.tool_count = 1;
    state.tools[0].X_WT.setIdentity();
    state.tools[0].X_WT.translation() = hpdm::Vector3d(0, 0, top - depth);
    state.tools[0].p_trocar_W = hpdm::Vector3d(0, 0, top + 0.2);
    tools.Publish();
    loop.Step(loop.NewestTools(), 0);
    patch.Update();
    const hpdm::ToolPatch& contact = patch.Front().tools[0].main();
    std::printf("tip %6.1f mm below the top: force on the tissue %6.3f N\n", 1000 * depth,
                contact.force_on_tissue_W.norm());
  }
}
