#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "engine/baselines/surface_error.h"
#include "engine/error.h"
#include "engine/static_loads.h"
#include "scenes/scene.h"
#include "tools/commands.h"
#include "tools/surface_table.h"

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

struct SolveOptions {
  std::string scene;
  std::string out;
  std::string reference;
  bool json = false;
};

double Milliseconds(Clock::time_point since) {
  return std::chrono::duration<double, std::milli>(Clock::now() - since).count();
}

// Median of repeated solves, loads to vertices; of finite strain, the time of one iteration.
double MedianSolveMicroseconds(const StaticLoads& loads) {
  constexpr std::size_t kMost = 21;
  constexpr double kLongEnough_ms = 2000;
  std::vector<double> times;
  double spent = 0;
  while (times.size() < kMost && spent < kLongEnough_ms) {
    const Clock::time_point start = Clock::now();
    const int iterations = loads.Solve().iterations;
    const double elapsed = Milliseconds(start);
    spent += elapsed;
    times.push_back(1000 * elapsed / std::max(iterations, 1));
  }
  const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
  std::nth_element(times.begin(), middle, times.end());
  return *middle;
}

// The organ that the loads act on: all of one organ's.
OrganOptions LoadedOrgan(const Scene& scene) {
  if (scene.loads.empty()) {
    throw InputError(scene.path.string() + ": has nothing to solve; add a [[load]] table");
  }
  for (const LoadOptions& load : scene.loads) {
    if (load.organ != scene.loads[0].organ) {
      throw InputError(scene.path.string() + ": loads act on \"" + scene.loads[0].organ +
                       "\" and \"" + load.organ + "\"; solve one organ a scene");
    }
  }
  return *std::find_if(scene.organs.begin(), scene.organs.end(), [&](const OrganOptions& organ) {
    return organ.name == scene.loads[0].organ;
  });
}

void Print(const SolveOptions& options, const Scene& scene, const Json& figures) {
  if (options.json) {
    std::cout << figures.dump(2) << "\n";
    return;
  }
  std::printf(
      "%s: %d control points and %d local functions, compliance %.4g m/N, largest displacement "
      "%.2f mm\n",
      scene.name.c_str(), figures["control_points"].get<int>(),
      figures["local_functions"].get<int>(), figures["compliance_m_per_N"].get<double>(),
      1000 * figures["largest_displacement_m"].get<double>());
  const int iterations = figures["newton_iterations"].get<int>();
  std::printf("set up in %.0f ms, %s in %.0f us, residual %.1e\n",
              figures["setup_ms"].get<double>(),
              iterations > 0 ? "each Newton iteration" : "solved", figures["step_us"].get<double>(),
              figures["residual"].get<double>());
  if (figures.contains("error")) {
    std::printf("error against %s: %.1f %% (area-weighted relative L2)\n",
                options.reference.c_str(), 100 * figures["error"].get<double>());
  }
}

void Solve(const SolveOptions& options) {
  const Scene scene = LoadScene(options.scene);
  const OrganOptions organ = LoadedOrgan(scene);
  std::vector<std::string> repairs;
  SurfaceMesh rest = LoadPosedMesh(organ, &repairs);
  const Clock::time_point start = Clock::now();
  const OrganModel model(organ, std::move(rest));
  const StaticLoads loads(model, scene.loads);
  const double setup_ms = Milliseconds(start);
  const StaticSolution solution = loads.Solve();
  WriteSurfaceTable(options.out, {model.rest().vertices, solution.vertex_displacements});

  Json figures = {
      {"scene", scene.name},
      {"control_points", model.control_points()},
      {"local_functions", loads.local_functions()},
      {"compliance_m_per_N", solution.Compliance()},
      {"largest_displacement_m", solution.vertex_displacements.rowwise().norm().maxCoeff()},
      {"volume_change", RelativeVolumeChange(model.rest(), solution.vertex_displacements)},
      {"residual", loads.Residual(solution)},
      {"load_share", solution.share},
      {"newton_iterations", solution.iterations},
      {"collapsed_share", solution.collapsed},
      {"setup_ms", setup_ms},
      {"step_us", MedianSolveMicroseconds(loads)}};
  for (std::size_t i = 0; i < scene.loads.size(); ++i) {
    const Vector3d& f = solution.load_forces[i];
    const Vector3d& u = solution.load_displacements[i];
    figures["loads"].push_back(
        {{"force_N", {f.x(), f.y(), f.z()}}, {"displacement_m", {u.x(), u.y(), u.z()}}});
  }
  if (!options.reference.empty()) {
    const SurfaceTable reference = ReadSurfaceTable(options.reference);
    if (reference.positions.rows() != model.rest().vertices.rows()) {
      throw InputError(options.reference + ": has " + std::to_string(reference.positions.rows()) +
                       " vertices, the organ " + std::to_string(model.rest().vertices.rows()) +
                       "; give the reference of the same mesh");
    }
    figures["error"] =
        RelativeSurfaceError(model.rest(), solution.vertex_displacements, reference.displacements);
  }
  Print(options, scene, figures);
  if (solution.collapsed > 0) {
    std::fprintf(stderr,
                 "%s: warning: %.2g %% of the tissue is inverted or compressed beyond what its law "
                 "resists; refine the lattice there, or take law = \"neo_hookean\"\n",
                 scene.path.c_str(), 100 * solution.collapsed);
  }
  if (solution.share < 1) {
    std::fprintf(stderr,
                 "%s: no equilibrium beyond %.3g of the loads, where the energy stops carrying "
                 "them; lower them or take law = \"neo_hookean\"\n",
                 scene.path.c_str(), solution.share);
    throw CLI::RuntimeError(1);
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
