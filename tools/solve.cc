#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "engine/baselines/surface_error.h"
#include "engine/static_loads.h"
#include "tools/commands.h"
#include "tools/static_case.h"
#include "tools/surface_table.h"
#include "tools/timing.h"

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;

struct SolveOptions {
  std::string scene;
  std::string out;
  std::string reference;
  bool json = false;
};

void Solve(const SolveOptions& options) {
  const StaticCase load_case = LoadStaticCase(options.scene);
  const Scene& scene = load_case.scene;
  const TimingClock::time_point start = TimingClock::now();
  const OrganModel model(load_case.organ, load_case.rest);
  const StaticLoads loads(model, scene.loads);
  const double setup_ms = MillisecondsSince(start);
  const StaticSolution solution = loads.Solve();
  WriteSurfaceTable(options.out, {model.rest().vertices, solution.vertex_displacements});

  Json figures = {
      {"scene", scene.name},
      {"control_points", model.lattice().size()},
      {"local_functions", loads.local_functions()},
      {"compliance_m_per_N", solution.Compliance()},
      {"largest_displacement_m", solution.vertex_displacements.rowwise().norm().maxCoeff()},
      {"volume_change", RelativeVolumeChange(model.rest(), solution.vertex_displacements)},
      {"residual", loads.Residual(solution)},
      {"setup_ms", setup_ms},
      {"step_us", Time([&] { loads.Solve(); }, {21, 21, 0}).median_us}};  // loads to vertices
  for (std::size_t i = 0; i < scene.loads.size(); ++i) {
    const Vector3d& f = solution.load_forces[i];
    const Vector3d& u = solution.load_displacements[i];
    figures["loads"].push_back(
        {{"force_N", {f.x(), f.y(), f.z()}}, {"displacement_m", {u.x(), u.y(), u.z()}}});
  }
  if (!options.reference.empty()) {
    figures["error"] =
        RelativeSurfaceError(model.rest(), solution.vertex_displacements,
                             ReadReferenceDisplacements(options.reference, model.rest()));
  }
  if (options.json) {
    std::cout << figures.dump(2) << "\n";
    return;
  }
  std::printf(
      "%s: %d control points and %d local functions, compliance %.4g m/N, largest displacement "
      "%.2f mm\n",
      scene.name.c_str(), model.lattice().size(), loads.local_functions(), solution.Compliance(),
      1000 * figures["largest_displacement_m"].get<double>());
  std::printf("set up in %.0f ms, solved in %.0f us, residual %.1e\n", setup_ms,
              figures["step_us"].get<double>(), loads.Residual(solution));
  if (figures.contains("error")) {
    std::printf("error against %s: %.1f %% (area-weighted relative L2)\n",
                options.reference.c_str(), 100 * figures["error"].get<double>());
  }
}

}  // namespace

void AddSolveCommand(CLI::App& app) {
  auto options = std::make_shared<SolveOptions>();
  CLI::App* solve = app.add_subcommand("solve", "Solve a scene's static load case");
  solve->add_option("scene", options->scene, "Scene file with [[load]] tables")->required();
  solve->add_option("--out", options->out, "CSV to write: x,y,z,ux,uy,uz of each vertex, m")
      ->required();
  solve->add_option("--reference", options->reference,
                    "CSV of the same form to measure the error against");
  solve->add_flag("--json", options->json, "Print JSON");
  solve->callback([options] { Solve(*options); });
}

}  // namespace hpdm
