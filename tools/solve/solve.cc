#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "engine/baselines/surface_error.h"
#include "engine/statics/static_loads.h"
#include "tools/command_line.h"
#include "tools/commands.h"
#include "tools/shared/staged_file.h"
#include "tools/shared/static_case.h"
#include "tools/shared/surface_table.h"
#include "tools/shared/timing.h"
#include "tools/shared/with_scene_path.h"
#include "tools/solve/solve_picture.h"

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;

struct SolveOptions {
  std::string scene;
  std::string out;
  std::string reference;
  std::string picture;
  bool json = false;
};

// Returns the median time of repeated solves, loads to vertices; in finite strain, of one
// iteration.
double MedianSolveMicroseconds(const StaticLoads& loads, int iterations) {
  return Time([&] { loads.Solve(); }, {3, 21, 2}).median_us / std::max(iterations, 1);
}

void Print(const SolveOptions& options, const Scene& scene, const Json& results) {
  if (options.json) {
    std::cout << results.dump(2) << "\n";
    return;
  }
  std::printf(
      "%s: %d control points and %d local functions, compliance %.4g m/N, largest displacement "
      "%.2f mm\n",
      scene.name.c_str(), results["control_points"].get<int>(),
      results["local_functions"].get<int>(), results["compliance_m_per_N"].get<double>(),
      1000 * results["largest_displacement_m"].get<double>());
  const int iterations = results["newton_iterations"].get<int>();
  std::printf("set up in %.0f ms, %s in %.0f us, residual %.1e\n",
              results["setup_ms"].get<double>(),
              iterations > 0 ? "each Newton iteration" : "solved", results["step_us"].get<double>(),
              results["residual"].get<double>());
  for (const Json& pressure : results.value("lumen_pressures_Pa", Json::array())) {
    std::printf("a lumen's pressure rises by %.4g Pa\n", pressure.get<double>());
  }
  for (const Json& layer : results.value("layers", Json::array())) {
    std::printf("a layer's largest tension is %.4g N/m", layer["tension_N_per_m"].get<double>());
    if (layer.contains("strength_N_per_m")) {
      std::printf(", %s its strength of %.4g N/m", layer["fails"].get<bool>() ? "beyond" : "below",
                  layer["strength_N_per_m"].get<double>());
    }
    std::printf("\n");
  }
  if (results.contains("error")) {
    std::printf("error against %s: %.1f %% (area-weighted relative L2)\n",
                options.reference.c_str(), 100 * results["error"].get<double>());
  }
  for (const Json& mesh : results.value("compared", Json::array())) {
    std::printf("  %s, %d nodes: %.1f %%\n", mesh["elements"].get<std::string>().c_str(),
                mesh["nodes"].get<int>(), 100 * mesh["error"].get<double>());
  }
  if (results.contains("picture")) {
    const Json& picture = results["picture"];
    std::printf("%s: coloured by %s, from 0 (dark blue) to %g mm (yellow)\n",
                options.picture.c_str(), picture["colours"].get<std::string>().c_str(),
                1000 * picture["full_scale_m"].get<double>());
  }
}

void AddSurfaceState(const OrganOptions& organ, const StaticSolution& solution, Json* results) {
  for (const double pressure : solution.lumen_pressures) {
    (*results)["lumen_pressures_Pa"].push_back(pressure);
  }
  for (std::size_t l = 0; l < solution.layer_tensions.size(); ++l) {
    const double tension = solution.layer_tensions[l];
    Json layer = {{"tension_N_per_m", tension}};
    if (const std::optional<double>& strength = organ.layers[l].strength) {
      layer["strength_N_per_m"] = *strength;
      layer["fails"] = tension > *strength;
    }
    (*results)["layers"].push_back(layer);
  }
}

// Returns the scene and every file that it names.
std::vector<std::string> FilesOf(const Scene& scene) {
  std::vector<std::string> files = {scene.path.string()};
  for (const SceneFile& file : scene.files) files.push_back(file.path);
  return files;
}

// Returns the load with a displacement on the same organ that is nearest to load i; i if there is none.
std::size_t NearestDisplaced(const Scene& scene, std::size_t i) {
  std::size_t nearest = i;
  double least = HUGE_VAL;
  for (std::size_t j = 0; j < scene.loads.size(); ++j) {
    const LoadOptions& other = scene.loads[j];
    if (j == i || !other.displacement_W || other.organ != scene.loads[i].organ) continue;
    const double distance = (other.p_centre_W - scene.loads[i].p_centre_W).norm();
    if (distance >= least) continue;
    least = distance;
    nearest = j;
  }
  return nearest;
}

// Refuses displacements that contradict each other: the solver would settle between them without a
// message. Which of them it misses is a matter of round-off, so the later one is named.
void RefuseContradictions(const Scene& scene, const StaticSolution& solution) {
  if (solution.share < 1) return;  // reported at the end
  for (std::size_t i = 0; i < scene.loads.size(); ++i) {
    const std::optional<Vector3d>& asked = scene.loads[i].displacement_W;
    // The tolerance is far above the solver's error.
    if (!asked || (solution.load_displacements[i] - *asked).norm() <= 1e-3 * asked->norm())
      continue;
    const std::size_t later = std::max(i, NearestDisplaced(scene, i));
    throw InputError(scene.path.string() + ": load[" + std::to_string(later) +
                     "]: its displacement contradicts another load at the same place; remove one");
  }
}

// Warns of collapsed tissue. Throws CheckFailed if the loads have no equilibrium.
void ReportFaults(const Scene& scene, const StaticSolution& solution) {
  if (solution.collapsed > 0) {
    std::fprintf(stderr,
                 "%s: warning: %.2g %% of the tissue is inverted or compressed beyond what its law "
                 "resists; refine the lattice there, or take law = \"neo_hookean\"\n",
                 OneLine(scene.path.string()).c_str(), 100 * solution.collapsed);
  }
  if (solution.share < 1) {
    std::fprintf(stderr,
                 "%s: no equilibrium beyond %.3g of the loads, where the energy stops carrying "
                 "them; lower them or take law = \"neo_hookean\"\n",
                 OneLine(scene.path.string()).c_str(), solution.share);
    throw CheckFailed();
  }
}

void Solve(const SolveOptions& options) {
  const StaticCase load_case = LoadStaticCase(options.scene);
  const Scene& scene = load_case.scene;
  std::vector<std::string> inputs = FilesOf(scene);
  std::optional<Points> reference;
  if (!options.reference.empty()) {
    inputs.push_back(options.reference);
    reference = ReadReferenceDisplacements(options.reference, load_case.rest);
  }
  for (const std::string& out : {options.out, options.picture}) RefuseOwnInput(out, inputs);
  const TimingClock::time_point start = TimingClock::now();
  const OrganModel model =
      WithScenePath(scene, [&] { return OrganModel(load_case.organ, load_case.rest); });
  const StaticLoads loads = WithScenePath(scene, [&] { return StaticLoads(model, scene.loads); });
  const double setup_ms = MillisecondsSince(start);
  const StaticSolution solution = loads.Solve();
  RefuseContradictions(scene, solution);
  WriteSurfaceTable(options.out, {model.rest().vertices, solution.vertex_displacements});

  Json results = {
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
      {"step_us", MedianSolveMicroseconds(loads, solution.iterations)}};
  for (std::size_t i = 0; i < scene.loads.size(); ++i) {
    const Vector3d& f = solution.load_forces[i];
    const Vector3d& u = solution.load_displacements[i];
    results["loads"].push_back(
        {{"force_N", {f.x(), f.y(), f.z()}}, {"displacement_m", {u.x(), u.y(), u.z()}}});
  }
  AddSurfaceState(model.options(), solution, &results);
  if (reference) {
    results["error"] =
        RelativeSurfaceError(model.rest(), solution.vertex_displacements, *reference);
    for (const ComparedTetrahedra& mesh : ComparedBeside(options.reference)) {
      results["compared"].push_back(
          {{"elements", KindOf(mesh)}, {"nodes", mesh.nodes}, {"error", mesh.error}});
    }
  }
  if (!options.picture.empty()) {
    const SolvedColours colours =
        WriteSolvedPicture(options.picture, load_case, solution.vertex_displacements,
                           reference ? &*reference : nullptr);
    results["picture"] = {{"file", options.picture},
                          {"colours", colours.error ? "error" : "displacement"},
                          {"full_scale_m", colours.full_scale}};
  }
  Print(options, scene, results);
  ReportFaults(scene, solution);
}

}  // namespace

void AddSolveCommand(Command app) {
  auto options = std::make_shared<SolveOptions>();
  Command solve = app.AddCommand("solve", "Solve a scene's static load case");
  solve.AddOption("scene", options->scene, "Scene file with [[load]] tables").Required();
  solve.AddOption("--out", options->out, "CSV to write: x,y,z,ux,uy,uz of each vertex, m")
      .Required();
  solve.AddOption(
      "--reference", options->reference,
      "CSV of the same form to measure the error against; the errors of tetrahedra that "
      "the JSON file beside it has are printed, too");
  solve.AddOption("--picture", options->picture,
                  "PNG to write: the solved shape through the scene's laparoscope, coloured by "
                  "its displacement, or with --reference by its error");
  solve.AddFlag("--json", options->json, "Print JSON");
  solve.OnRun([options] { Solve(*options); });
}

}  // namespace hpdm
