#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <set>
#include <string>

#include "engine/base/error.h"
#include "scenes/generator/meshing/obj_writer.h"
#include "tools/bench/bench_results.h"
#include "tools/command_line.h"
#include "tools/commands.h"
#include "tools/shared/json_text.h"
#include "tools/shared/machine_facts.h"
#include "tools/shared/staged_file.h"

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;

struct BenchOptions {
  std::string json;
  std::string out;
  std::set<std::string> only;
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

Json ToJson(const SleepResults& row) {
  Json json = {{"scene", row.scene},         {"sleeping", row.sleeping},
               {"triangles", row.triangles}, {"among", ToJson(row.among)},
               {"alone", ToJson(row.alone)}, {"ratio", ToJson(row.ratio)}};
  if (row.idle_us) json["all_asleep_us"] = *row.idle_us;
  return json;
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

Json ToJson(const TickResults& ticks) {
  return {{"organs_each", ticks.organs},
          {"coarse_triangles", ticks.coarse_triangles},
          {"fine_triangles", ticks.fine_triangles},
          {"coarse", ToJson(ticks.coarse)},
          {"fine", ToJson(ticks.fine)},
          {"with_new_patch", ToJson(ticks.with_new_patch)},
          {"bare_loop", ToJson(ticks.bare)},
          {"ratio", ToJson(ticks.ratio)}};
}

Json ToJson(const HandOverResults& row) {
  return {{"snapshot", row.snapshot},
          {"bytes", row.bytes},
          {"publish", ToJson(row.publish)},
          {"update", ToJson(row.update)}};
}

Json ToJson(const FrameResults& row) {
  return {{"scene", row.scene},
          {"triangles", row.triangles},
          {"width", row.width},
          {"height", row.height},
          {"way", row.way},
          {"frame", ToJson(row.frame)},
          {"cores", ToJson(row.cores)}};
}

Json ToJson(const FfdTable& table) {
  Json rows;
  for (const FfdResults& row : table.rows) {
    rows.push_back({{"lattice", row.lattice},
                    {"control_points", row.control_points},
                    {"triangles", row.triangles},
                    {"cpu_step", ToJson(row.step)},
                    {"cpu_upload", ToJson(row.upload)},
                    {"shader", ToJson(row.shader)},
                    {"shader_over_cpu", row.ratio}});
  }
  return {{"renderer", table.renderer}, {"rows", rows}};
}

Json ToJson(const OrganResults& organs) {
  Json searches;
  for (const PairSearchResults& row : organs.searches) {
    searches.push_back({{"pair", row.pair},
                        {"first_triangles", row.first_triangles},
                        {"second_triangles", row.second_triangles},
                        {"found", row.found},
                        {"own", ToJson(row.own)},
                        {"fcl_found", row.fcl_found},
                        {"fcl_collide", ToJson(row.fcl_collide)},
                        {"fcl_distance", ToJson(row.fcl_distance)},
                        {"own_refit", ToJson(row.own_refit)},
                        {"fcl_refit", ToJson(row.fcl_refit)}});
  }
  Json steps;
  for (const StepTimes& row : organs.steps) {
    steps.push_back({{"scene", row.scene},
                     {"all", ToJson(row.all)},
                     {"touching", ToJson(row.touching)},
                     {"most_contacts", row.most_contacts}});
  }
  return {{"searches", searches}, {"steps", steps}};
}

Json ToJson(const BenchResults& results, const MachineFacts& machine) {
  Json json = {{"machine", ToJson(machine)}};
  for (const ModelComparison& row : results.models) json["models"].push_back(ToJson(row));
  for (const MeshComparison& row : results.meshes) json["meshes"].push_back(ToJson(row));
  for (const SleepResults& row : results.sleep) json["sleep"].push_back(ToJson(row));
  for (const CostCurve& curve : results.costs) json["costs"].push_back(ToJson(curve));
  for (const TickResults& row : results.ticks) json["ticks"].push_back(ToJson(row));
  if (!results.hand_overs.empty()) json["clock_reading_us"] = results.clock_reading_ns / 1000;
  for (const HandOverResults& row : results.hand_overs) json["hand_overs"].push_back(ToJson(row));
  for (const FrameResults& row : results.frames) json["frames"].push_back(ToJson(row));
  if (results.ffd.has_value()) json["ffd"] = ToJson(*results.ffd);
  if (results.organs.has_value()) json["organs"] = ToJson(*results.organs);
  return json;
}

void Bench(const BenchOptions& options) {
  namespace fs = std::filesystem;
  if (!options.out.empty()) MakeOutFolder(options.out);
  const MachineFacts machine = ThisMachine();
  const TimingClock::time_point start = TimingClock::now();
  const auto progress = [&](const char* next) {
    std::fprintf(stderr, "%5.1f s: %s\n", MillisecondsSince(start) / 1000, next);
  };
  BenchResults results;
  const auto wanted = [&](const char* what, const char* words) {
    const bool yes = options.only.empty() || options.only.contains(what);
    if (yes) progress(words);
    return yes;
  };
  if (wanted("ticks", "haptic ticks")) results.ticks = TimeTicks(options.quick);
  if (wanted("hand-over", "hand-over of snapshots")) {
    results.clock_reading_ns = ClockReadingNanoseconds();
    results.hand_overs = TimeHandOvers(options.quick);
  }
  if (wanted("frames", "frames of the laparoscope's picture")) {
    results.frames = TimeFrames(options.quick);
    if (results.frames.empty() && options.only.contains("frames")) {
      throw InputError(
          "scenes: no scenes to draw; run the command in the folder that holds scenes/");
    }
  }
  if (wanted("models", "lattice and surface continuum")) {
    results.models = CompareModels(options.quick);
  }
  if (wanted("meshes", "coarse and fine triangles")) results.meshes = CompareMeshes(options.quick);
  if (wanted("sleep", "sleeping organs")) results.sleep = TimeSleep(options.quick);
  if (wanted("costs", "cost of vertices and of control points")) {
    results.costs = CostOfVertices(options.quick);
    const std::vector<CostCurve> of_control_points = CostOfControlPoints(options.quick);
    results.costs.insert(results.costs.end(), of_control_points.begin(), of_control_points.end());
  }
  if (wanted("ffd", "deformation on the CPU and in the shader")) {
    results.ffd = TimeFfd(options.quick);
  }
  if (wanted("organs", "organs on each other")) results.organs = TimeOrgans(options.quick);
  progress("done");

  const std::string markdown = BenchMarkdown(results, ToText(machine));
  const std::string organs =
      results.organs ? OrganMarkdown(*results.organs, ToText(machine)) : std::string();
  const std::string json = JsonText(ToJson(results, machine)) + "\n";
  if (!options.json.empty()) WriteTextFile(options.json, json);
  if (!options.out.empty()) {
    WriteTextFile(fs::path(options.out) / "bench.json", json);
    WriteTextFile(fs::path(options.out) / "bench.md", markdown);
    if (!organs.empty()) WriteTextFile(fs::path(options.out) / "organs.md", organs);
  }
  std::cout << markdown << organs;
}

}  // namespace

void AddBenchCommand(Command app) {
  const auto options = std::make_shared<BenchOptions>();
  Command bench =
      app.AddCommand("bench", "Time the paper's tables and how the cost grows with size");
  bench.AddOption("--json", options->json, "File to write all figures to");
  bench.AddOption("--out", options->out,
                  "Folder for bench.json, bench.md and organs.md; created if missing");
  bench.AddOption("--only", options->only, "Measure only these")
      .OneOf(
          {"ticks", "hand-over", "frames", "ffd", "models", "meshes", "sleep", "costs", "organs"});
  bench.AddFlag("--quick", options->quick, "Fewer repeats and smaller sizes");
  bench.OnRun([options] { Bench(*options); });
}

}  // namespace hpdm
