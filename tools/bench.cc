#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <system_error>

#include "engine/error.h"
#include "scenes/obj_writer.h"
#include "tools/bench_figures.h"
#include "tools/commands.h"
#include "tools/json_figures.h"
#include "tools/machine_facts.h"

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;

struct BenchOptions {
  std::string json;
  std::string out;
  bool quick = false;
};

Json ToJson(const Timing& timing) {
  return {{"median_us", timing.median_us}, {"min_us", timing.minimum_us}};
}

Json ToJson(const RatioSpread& ratio) {
  return {{"median", ratio.median}, {"p10", ratio.low}, {"p90", ratio.high}};
}

Json ToJson(const ModelComparison& row) {
  return {{"lattice", row.lattice},
          {"continuum", row.continuum},
          {"second_organ", row.second_organ},
          {"lattice_step", ToJson(row.lattice_step)},
          {"continuum_step", ToJson(row.continuum_step)},
          {"lattice_residual", row.lattice_residual},
          {"continuum_residual", row.continuum_residual},
          {"ratio", ToJson(row.ratio)}};
}

Json ToJson(const MeshComparison& row) {
  return {{"lattice", row.energy},
          {"instruments", row.instruments},
          {"instrument_polygons", row.polygons},
          {"coarse_triangles", row.coarse_triangles},
          {"coarse_step", ToJson(row.coarse)},
          {"fine_triangles", row.fine_triangles},
          {"fine_step", ToJson(row.fine)},
          {"ratio", ToJson(row.ratio)}};
}

Json ToJson(const CostCurve& curve) {
  return {{"cost", curve.what},
          {"of", curve.of},
          {"size", curve.size},
          {"min_us", curve.us},
          {"fitted_from", curve.fitted_from},
          {"exponent", curve.law.exponent},
          {"factor_us", curve.law.factor},
          {"r_squared", curve.law.r_squared}};
}

Json ToJson(const BenchFigures& figures, const MachineFacts& machine) {
  Json json = {{"machine", ToJson(machine)}};
  for (const ModelComparison& row : figures.models) json["models"].push_back(ToJson(row));
  for (const MeshComparison& row : figures.meshes) json["meshes"].push_back(ToJson(row));
  for (const CostCurve& curve : figures.costs) json["costs"].push_back(ToJson(curve));
  return json;
}

void Bench(const BenchOptions& options) {
  namespace fs = std::filesystem;
  if (!options.out.empty()) {
    std::error_code error;
    fs::create_directories(options.out, error);
    if (error) {
      throw InputError(options.out + ": cannot be created (" + error.message() +
                       "); choose another --out");
    }
  }
  const MachineFacts machine = ThisMachine();
  const TimingClock::time_point start = TimingClock::now();
  const auto progress = [&](const char* next) {
    std::fprintf(stderr, "%5.1f s: %s\n", MillisecondsSince(start) / 1000, next);
  };
  BenchFigures figures;
  progress("lattice and surface continuum");
  figures.models = CompareModels(options.quick);
  progress("coarse and fine triangles");
  figures.meshes = CompareMeshes(options.quick);
  progress("cost of vertices");
  figures.costs = CostOfVertices(options.quick);
  progress("cost of control points");
  const std::vector<CostCurve> of_control_points = CostOfControlPoints(options.quick);
  figures.costs.insert(figures.costs.end(), of_control_points.begin(), of_control_points.end());
  progress("done");

  const std::string markdown = BenchMarkdown(figures, ToText(machine));
  const std::string json = JsonText(ToJson(figures, machine)) + "\n";
  if (!options.json.empty()) WriteTextFile(options.json, json);
  if (!options.out.empty()) {
    WriteTextFile(fs::path(options.out) / "bench.json", json);
    WriteTextFile(fs::path(options.out) / "bench.md", markdown);
  }
  std::cout << markdown;
}

}  // namespace

void AddBenchCommand(CLI::App& app) {
  const auto options = std::make_shared<BenchOptions>();
  CLI::App* bench =
      app.add_subcommand("bench", "Time the paper's tables and what the cost grows with");
  bench->add_option("--json", options->json, "File to write all figures to");
  bench->add_option("--out", options->out, "Folder for bench.json and bench.md; made when missing");
  bench->add_flag("--quick", options->quick, "Fewer repeats and smaller sizes");
  bench->callback([options] { Bench(*options); });
}

}  // namespace hpdm
