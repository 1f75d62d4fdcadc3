#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "engine/base/text_list.h"
#include "scenes/loader/instrument_types.h"
#include "tools/command_line.h"
#include "tools/commands.h"
#include "tools/session/session.h"
#include "tools/shared/json_text.h"

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;

const char* ModelName(OrganModelType model) {
  switch (model) {
    case OrganModelType::kHpdm:
      return "hpdm";
    case OrganModelType::kContinuum:
      return "continuum";
    case OrganModelType::kMassSpring:
      return "mass_spring";
    case OrganModelType::kRigid:
      return "rigid";
  }
  return "";
}

Json OrganFacts(const OrganModel& organ) {
  Json facts = {{"name", organ.options().name},
                {"mesh", organ.options().mesh},
                {"model", ModelName(organ.options().model)},
                {"vertices", organ.rest().vertices.rows()},
                {"triangles", organ.rest().triangles.rows()},
                {"tissue_volume_m3", organ.tissue_volume()},
                {"control_points", organ.control_points()},
                {"stiffness_regions", organ.options().regions.size()},
                {"supports", organ.options().supports.size()}};
  if (organ.rigid()) return facts;
  // Unknowns that are coupled: one axis at a time (metric, continuum), or all three.
  double unknowns = organ.control_points();
  if (organ.lattice()) {
    const Lattice& lattice = *organ.lattice();
    const Vector3d size = 1000 * lattice.box().lengths;
    facts["lattice_mm"] = {size.x(), size.y(), size.z()};
    facts["control_points_dropped"] = lattice.basis().count() - lattice.size();
    if (organ.options().energy.type == EnergyType::kStrain) unknowns *= 3;
    facts["cost"]["matrix_bytes"] = 8 * unknowns * unknowns;
    if (organ.refinement_basis() != nullptr) {
      facts["local_functions"] = LocalFunctionsOf(organ.options());
      facts["refinement_functions"] = organ.refinement_basis()->size();
      facts["cost"]["refinement_bytes"] = organ.refinement_basis()->Bytes();
      // Deprecated names of the two.
      facts["local_candidates"] = organ.refinement_basis()->size();
      facts["cost"]["local_bytes"] = organ.refinement_basis()->Bytes();
    }
  } else if (organ.springs() != nullptr) {
    unknowns *= 3;
    facts["cost"]["springs"] = organ.springs()->springs().size();
    facts["cost"]["substeps"] = organ.springs()->substeps();
  } else {
    const auto& K = std::get<ScalarStiffness>(organ.stiffness());
    facts["cost"]["matrix_bytes"] = 12 * K.nonZeros();  // sparse: a number and its column
  }
  facts["cost"]["unknowns"] = unknowns;
  facts["cost"]["relocation_flops"] = 6.0 * static_cast<double>(organ.weights().nonZeros());
  return facts;
}

void PrintOrgan(const Json& organ) {
  std::printf("organ %s: %ld vertices, %ld triangles, %.3f l of tissue\n",
              organ["name"].get<std::string>().c_str(), organ["vertices"].get<long>(),
              organ["triangles"].get<long>(), 1000 * organ["tissue_volume_m3"].get<double>());
  if (organ["model"] == "rigid") {
    std::printf("  rigid: a virtual wall, at no cost but that of collision\n");
    return;
  }
  if (organ.contains("lattice_mm")) {
    std::printf(
        "  lattice of %.0f x %.0f x %.0f mm, %ld control points (%ld without tissue dropped)\n",
        organ["lattice_mm"][0].get<double>(), organ["lattice_mm"][1].get<double>(),
        organ["lattice_mm"][2].get<double>(), organ["control_points"].get<long>(),
        organ["control_points_dropped"].get<long>());
    if (organ.contains("local_functions")) {
      std::printf("  at most %ld of %ld local functions a contact, %.1f MB for them\n",
                  organ["local_functions"].get<long>(), organ["refinement_functions"].get<long>(),
                  organ["cost"]["refinement_bytes"].get<double>() / 1e6);
    }
  } else {
    std::printf("  model %s on the vertices\n", organ["model"].get<std::string>().c_str());
  }
  if (const long regions = organ["stiffness_regions"].get<long>(); regions > 0) {
    std::printf("  %ld region%s of other stiffness\n", regions, regions == 1 ? "" : "s");
  }
  const Json& cost = organ["cost"];
  std::printf("  %.0f coupled unknowns, ", cost["unknowns"].get<double>());
  if (cost.contains("springs")) {
    std::printf("%ld springs, %ld substeps a step; ", cost["springs"].get<long>(),
                cost["substeps"].get<long>());
  } else {
    std::printf("%.1f MB a matrix; ", cost["matrix_bytes"].get<double>() / 1e6);
  }
  std::printf("%.2f Mflop to relocate the vertices\n",
              cost["relocation_flops"].get<double>() / 1e6);
}

std::string_view TypeName(InstrumentType type) {
  for (const auto& [name, named] : kInstrumentTypes) {
    if (named == type) return name;
  }
  return "";
}

Json InstrumentFacts(const InstrumentOptions& instrument, const DeviceChoice& device) {
  Json facts = {{"name", instrument.name},
                {"type", TypeName(instrument.type)},
                {"device", device.Text()},
                {"exchanges", Json::array()}};
  for (const InstrumentDescription& held : instrument.exchanges) {
    facts["exchanges"].push_back({{"name", held.name}, {"type", TypeName(held.type)}});
  }
  return facts;
}

void PrintInstrument(const Json& instrument) {
  const auto text = [](const Json& value) { return value.get<std::string>(); };
  std::printf("instrument %s: %s, device %s\n", text(instrument["name"]).c_str(),
              text(instrument["type"]).c_str(), text(instrument["device"]).c_str());
  std::string exchanges;
  for (const Json& held : instrument["exchanges"]) {
    AppendToList(text(held["name"]) + " (" + text(held["type"]) + ")", &exchanges);
  }
  if (!exchanges.empty()) std::printf("  can be exchanged for %s\n", exchanges.c_str());
}

Json ContactFacts(const Session::ContactFact& contact) {
  const StiffestContact& at = contact.stiffest;
  return {{"instrument", contact.instrument},
          {"organ", contact.organ},
          {"axis", AxisName(at.axis)},
          {"at_m", {at.p_W.x(), at.p_W.y(), at.p_W.z()}},
          {"stiffness_N_per_m", at.stiffness},
          {"passive_to_N_per_m", at.limit.passivity},
          {"stable_to_N_per_m", at.limit.stability}};
}

void PrintContact(const Json& contact) {
  std::printf(
      "  on organ %s: at most %.0f N/m (%s); its device is passive to %.0f, stable to %.0f\n",
      contact["organ"].get<std::string>().c_str(), contact["stiffness_N_per_m"].get<double>(),
      contact["axis"].get<std::string>().c_str(), contact["passive_to_N_per_m"].get<double>(),
      contact["stable_to_N_per_m"].get<double>());
}

// Of an instrument at a rigid organ.
Json WallFacts(const std::string& instrument, const OrganOptions& organ, const VirtualWall& wall) {
  return {{"instrument", instrument},
          {"organ", organ.name},
          {"stiffness_N_per_m", organ.wall_stiffness.value_or(wall.stiffness)},
          {"given", organ.wall_stiffness.has_value()},
          {"stable_to_N_per_m", wall.limit},
          {"axis", AxisName(wall.axis)},
          {"lever_m", wall.lever},
          {"reachable", wall.reachable}};
}

void PrintWall(const Json& wall) {
  std::printf(
      "  on organ %s: a wall of %.0f N/m, %s the %.0f N/m that its device displays stably "
      "(%s, %.0f mm from the trocar%s)\n",
      wall["organ"].get<std::string>().c_str(), wall["stiffness_N_per_m"].get<double>(),
      wall["given"].get<bool>() ? "given, of" : "half of", wall["stable_to_N_per_m"].get<double>(),
      wall["axis"].get<std::string>().c_str(), 1000 * wall["lever_m"].get<double>(),
      wall["reachable"].get<bool>() ? "" : ", its longest: it reaches no rigid organ");
}

std::string AccuracyOfMetric(const std::string& organ) {
  return "organ \"" + organ +
         "\": energy.type = \"metric\" is the paper's model; under a press its surface is 51 to 91 "
         "% off quadratic tetrahedra; give \"strain\" for realistic tissue";
}

void Check(const std::string& scene, bool as_json) {
  const Session session(LoadScene(scene));
  Json facts = {
      {"scene", session.scene().name}, {"organs", Json::array()}, {"instruments", Json::array()}};
  for (const OrganModel& organ : session.organs()) facts["organs"].push_back(OrganFacts(organ));
  for (std::size_t i = 0; i < session.scene().instruments.size(); ++i) {
    facts["instruments"].push_back(
        InstrumentFacts(session.scene().instruments[i], session.device_choices()[i]));
  }
  facts["contacts"] = Json::array();
  for (const Session::ContactFact& contact : session.contacts()) {
    facts["contacts"].push_back(ContactFacts(contact));
  }
  facts["walls"] = Json::array();
  for (std::size_t i = 0; i < session.walls().size(); ++i) {
    for (const OrganModel& organ : session.organs()) {
      if (!organ.rigid()) continue;
      facts["walls"].push_back(
          WallFacts(session.scene().instruments[i].name, organ.options(), session.walls()[i]));
    }
  }
  facts["remarks"] = session.remarks();
  for (const OrganModel& organ : session.organs()) {
    if (organ.lattice() && organ.options().energy.type == EnergyType::kMetric) {
      facts["remarks"].push_back(AccuracyOfMetric(organ.options().name));
    }
  }
  if (as_json) {
    std::cout << JsonText(facts) << "\n";
    return;
  }
  std::cout << facts["scene"].get<std::string>() << ": sound\n";
  for (const Json& organ : facts["organs"]) PrintOrgan(organ);
  for (const Json& instrument : facts["instruments"]) {
    PrintInstrument(instrument);
    for (const Json& contact : facts["contacts"]) {
      if (contact["instrument"] == instrument["name"]) PrintContact(contact);
    }
    for (const Json& wall : facts["walls"]) {
      if (wall["instrument"] == instrument["name"]) PrintWall(wall);
    }
  }
  for (const Json& remark : facts["remarks"]) {
    std::printf("note: %s\n", remark.get<std::string>().c_str());
  }
}

}  // namespace

void AddCheckCommand(Command app) {
  auto scene = std::make_shared<std::string>();
  auto as_json = std::make_shared<bool>(false);
  Command check =
      app.AddCommand("check", "Validate a scene and say what would be built and its cost");
  check.AddOption("scene", *scene, "Scene file (TOML; see scenes/README.md)").Required();
  check.AddFlag("--json", *as_json, "Print JSON");
  check.OnRun([scene, as_json] { Check(*scene, *as_json); });
}

}  // namespace hpdm
