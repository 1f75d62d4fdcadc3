#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "tools/commands.h"
#include "tools/json_figures.h"
#include "tools/session.h"

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;

Json OrganFacts(const OrganModel& organ) {
  const Lattice& lattice = organ.lattice();
  // Unknowns that are coupled: one axis at a time (metric), or all three (strain).
  const bool strain = organ.options().energy.type == EnergyType::kStrain;
  const double unknowns = lattice.size() * (strain ? 3.0 : 1.0);
  const Vector3d size = 1000 * lattice.box().lengths;
  return {{"name", organ.options().name},
          {"mesh", organ.options().mesh},
          {"vertices", organ.rest().vertices.rows()},
          {"triangles", organ.rest().triangles.rows()},
          {"tissue_volume_m3", organ.tissue_volume()},
          {"lattice_mm", {size.x(), size.y(), size.z()}},
          {"control_points", lattice.size()},
          {"control_points_dropped", lattice.basis().count() - lattice.size()},
          {"supports", organ.options().supports.size()},
          {"cost",
           {{"unknowns", unknowns},
            {"relocation_flops", 6.0 * static_cast<double>(organ.weights().nonZeros())},
            {"matrix_bytes", 8 * unknowns * unknowns}}}};
}

void Check(const std::string& scene, bool as_json) {
  const Session session(LoadScene(scene));
  Json facts = {
      {"scene", session.scene().name}, {"organs", Json::array()}, {"instruments", Json::array()}};
  for (const OrganModel& organ : session.organs()) facts["organs"].push_back(OrganFacts(organ));
  for (const InstrumentOptions& instrument : session.scene().instruments) {
    facts["instruments"].push_back(instrument.name);
  }
  facts["remarks"] = session.remarks();
  if (as_json) {
    std::cout << JsonText(facts) << "\n";
    return;
  }
  std::cout << facts["scene"].get<std::string>() << ": sound\n";
  for (const Json& organ : facts["organs"]) {
    std::printf("organ %s: %ld vertices, %ld triangles, %.3f l of tissue\n",
                organ["name"].get<std::string>().c_str(), organ["vertices"].get<long>(),
                organ["triangles"].get<long>(), 1000 * organ["tissue_volume_m3"].get<double>());
    std::printf(
        "  lattice of %.0f x %.0f x %.0f mm, %ld control points (%ld without tissue dropped)\n",
        organ["lattice_mm"][0].get<double>(), organ["lattice_mm"][1].get<double>(),
        organ["lattice_mm"][2].get<double>(), organ["control_points"].get<long>(),
        organ["control_points_dropped"].get<long>());
    const Json& cost = organ["cost"];
    std::printf("  %.0f coupled unknowns, %.1f MB a matrix; %.2f Mflop to relocate the vertices\n",
                cost["unknowns"].get<double>(), cost["matrix_bytes"].get<double>() / 1e6,
                cost["relocation_flops"].get<double>() / 1e6);
  }
  for (const Json& name : facts["instruments"]) {
    std::printf("instrument %s\n", name.get<std::string>().c_str());
  }
  for (const Json& remark : facts["remarks"]) {
    std::printf("note: %s\n", remark.get<std::string>().c_str());
  }
}

}  // namespace

void AddCheckCommand(CLI::App& app) {
  auto scene = std::make_shared<std::string>();
  auto as_json = std::make_shared<bool>(false);
  CLI::App* check =
      app.add_subcommand("check", "Validate a scene and say what would be built and its cost");
  check->add_option("scene", *scene, "Scene file (TOML; see scenes/README.md)")->required();
  check->add_flag("--json", *as_json, "Print JSON");
  check->callback([scene, as_json] { Check(*scene, *as_json); });
}

}  // namespace hpdm
