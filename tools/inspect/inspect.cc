#include <charconv>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "engine/base/error.h"
#include "engine/mesh/files/mesh_import.h"
#include "engine/mesh/mesh_facts.h"
#include "engine/mesh/organ_size.h"
#include "tools/command_line.h"
#include "tools/commands.h"
#include "tools/shared/json_text.h"

namespace hpdm {
namespace {

struct InspectOptions {
  std::string mesh;
  std::string unit = "m";
  bool unit_given = false;
  bool json = false;
};

double MetresPerUnit(const std::string& unit) {
  if (unit == "m") return 1;
  if (unit == "mm") return 1e-3;
  double metres = 0;
  const auto [end, error] = std::from_chars(unit.data(), unit.data() + unit.size(), metres);
  if (error != std::errc() || end != unit.data() + unit.size() || !(metres > 0) ||
      !std::isfinite(metres)) {
    throw InputError("--unit " + unit + ": not a unit; give m, mm or metres per unit");
  }
  return metres;
}

void PrintJson(const std::string& path, const MeshFacts& facts, const ImportedMesh& imported) {
  nlohmann::ordered_json json = {
      {"mesh", path},
      {"vertices", facts.vertices},
      {"triangles", facts.triangles},
      {"closed", facts.Closed()},
      {"boundary_edges", facts.boundary_edges},
      {"nonmanifold_edges", facts.nonmanifold_edges},
      {"inconsistent_edges", facts.inconsistent_edges},
      {"degenerate_triangles", facts.degenerate_triangles},
      {"components", facts.components},
      {"euler_characteristic", facts.euler_characteristic},
      {"volume_m3", facts.volume_m3},
      {"area_m2", facts.area_m2},
      {"box_min_m", {facts.box_min.x(), facts.box_min.y(), facts.box_min.z()}},
      {"box_max_m", {facts.box_max.x(), facts.box_max.y(), facts.box_max.z()}},
      {"min_edge_m", facts.min_edge},
      {"mean_edge_m", facts.mean_edge}};
  json["genus"] = facts.genus ? nlohmann::ordered_json(*facts.genus) : nullptr;
  json["repairs"] = nlohmann::ordered_json::object();
  for (const auto& [name, count] : imported.repairs.List()) json["repairs"][name] = count;
  const MeshFacts& as_read = imported.as_read;
  json["as_read"] = {{"vertices", as_read.vertices},
                     {"triangles", as_read.triangles},
                     {"boundary_edges", as_read.boundary_edges},
                     {"nonmanifold_edges", as_read.nonmanifold_edges},
                     {"inconsistent_edges", as_read.inconsistent_edges},
                     {"degenerate_triangles", as_read.degenerate_triangles},
                     {"components", as_read.components},
                     {"volume_m3", as_read.volume_m3}};
  std::puts(JsonText(json).c_str());
}

void PrintText(const std::string& path, const MeshFacts& facts, const ImportedMesh& imported) {
  const Vector3d size = facts.box_max - facts.box_min;
  std::printf("%s\n", path.c_str());
  std::printf("  surface     %d vertices, %d triangles, %d component%s, %s\n", facts.vertices,
              facts.triangles, facts.components, facts.components == 1 ? "" : "s",
              facts.Closed() ? "closed" : "not closed");
  std::printf("  edges       %d boundary, %d non-manifold, %d inconsistent\n", facts.boundary_edges,
              facts.nonmanifold_edges, facts.inconsistent_edges);
  std::printf("  edge length %.4g mm mean, %.4g mm shortest; %d degenerate triangles\n",
              1e3 * facts.mean_edge, 1e3 * facts.min_edge, facts.degenerate_triangles);
  std::printf("  size        %.4g x %.4g x %.4g mm from (%.4g, %.4g, %.4g) mm\n", 1e3 * size.x(),
              1e3 * size.y(), 1e3 * size.z(), 1e3 * facts.box_min.x(), 1e3 * facts.box_min.y(),
              1e3 * facts.box_min.z());
  std::printf("  volume      %.6g l%s, area %.6g cm^2\n", 1e3 * facts.volume_m3,
              facts.Closed() ? "" : " (an estimate: the surface is not closed)",
              1e4 * facts.area_m2);
  std::printf("  topology    Euler characteristic %d", facts.euler_characteristic);
  if (facts.genus) std::printf(", genus %d", *facts.genus);
  std::printf("\n  repairs     ");
  const auto repairs = imported.repairs.List();
  if (repairs.empty()) std::printf("none");
  const char* separator = "";
  for (const auto& [name, count] : repairs) {
    std::printf("%s%s %d", separator, name.c_str(), count);
    separator = ", ";
  }
  std::printf("\n");
  if (repairs.empty()) return;
  const MeshFacts& as_read = imported.as_read;
  std::printf(
      "  as read     %d vertices, %d triangles (%d degenerate), %d boundary, %d non-manifold and "
      "%d "
      "inconsistent edges\n",
      as_read.vertices, as_read.triangles, as_read.degenerate_triangles, as_read.boundary_edges,
      as_read.nonmanifold_edges, as_read.inconsistent_edges);
}

void Inspect(const InspectOptions& options) {
  const double unit_m = MetresPerUnit(options.unit);
  const ImportedMesh imported = ImportMesh(options.mesh, unit_m);
  if (const OrganSize size = SizeOfOrgan(imported.mesh, unit_m); !size.IsOrgan()) {
    const std::string fault =
        options.mesh + ": " + size.Text() + "; give --unit " + size.likely_unit;
    // The facts of a mesh that is not an organ are printed for its stated unit.
    if (!options.unit_given) throw InputError(fault + ", or --unit m if that is its size");
    std::fprintf(stderr, "hpdm: %s\n", OneLine(fault).c_str());
  }
  const MeshFacts facts = ComputeMeshFacts(imported.mesh);
  if (options.json) {
    PrintJson(options.mesh, facts, imported);
  } else {
    PrintText(options.mesh, facts, imported);
  }
}

}  // namespace

void AddInspectCommand(Command app) {
  // Shared with the callback, which outlives this function.
  const auto options = std::make_shared<InspectOptions>();
  Command command = app.AddCommand("inspect", "Facts and repairs of a surface mesh");
  command.AddOption("mesh", options->mesh, "OBJ, STL or PLY file").Required();
  const Option unit =
      command.AddOption("--unit", options->unit, "Unit of the file: m, mm or metres per unit")
          .ShowDefault();
  command.AddFlag("--json", options->json, "Print JSON");
  command.OnRun([options, unit] {
    options->unit_given = unit.Given();
    Inspect(*options);
  });
}

}  // namespace hpdm
