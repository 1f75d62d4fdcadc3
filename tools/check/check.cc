#include <cstddef>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/text_list.h"
#include "engine/tissue/support.h"
#include "scenes/loader/instrument_types.h"
#include "tools/check/scene_schema.h"
#include "tools/command_line.h"
#include "tools/commands.h"
#include "tools/session/session.h"
#include "tools/shared/json_text.h"
#include "tools/shared/report_text.h"

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

Json Coordinates(const Vector3d& p_W) { return {p_W.x(), p_W.y(), p_W.z()}; }

// The volume of the tissue that each support of an organ holds, m^3.
std::vector<double> SupportVolumes(const OrganModel& organ, const Box& bounds) {
  if (organ.lattice_organ() != nullptr) return organ.lattice_organ()->support_volumes();
  constexpr int kSamples = 8;  // across the longest side
  const double spacing = (bounds.max - bounds.min).maxCoeff() / kSamples;
  std::vector<double> volumes;
  for (const SupportOptions& support : organ.options().supports) {
    volumes.push_back(SampleSupport(organ.rest(), support, bounds, spacing).weights.sum());
  }
  return volumes;
}

// The tissue that each support of an organ holds, in the order of the scene.
Json SupportFacts(const OrganModel& organ, const Box& bounds) {
  const std::vector<double> volumes = SupportVolumes(organ, bounds);
  Json held = Json::array();
  for (std::size_t s = 0; s < volumes.size(); ++s) {
    Json facts = {{"tissue_volume_m3", volumes[s]}, {"share", volumes[s] / organ.tissue_volume()}};
    const std::optional<double>& stiffness = organ.options().supports[s].stiffness;
    if (stiffness) facts["stiffness_Pa_per_m2"] = *stiffness;
    held.push_back(facts);
  }
  return held;
}

Json CutFacts(const CutSurface& cut) {
  double area = 0;
  for (const CutSurface::Sample& sample : cut.samples()) area += sample.area;
  return {{"triangles", cut.triangles().size()},
          {"area_in_tissue_m2", area},
          {"ends_in_tissue", cut.has_front()}};
}

void AddSurfaceFacts(const OrganModel& organ, Json* facts) {
  const FillingsAndLayers& surface = organ.lattice_organ()->fillings_and_layers();
  for (const Lumen& lumen : surface.lumens()) {
    (*facts)["lumens"].push_back({{"volume_m3", lumen.volume},
                                  {"bulk_modulus_Pa", lumen.bulk_modulus},
                                  {"pressure_Pa", lumen.pressure}});
  }
  for (std::size_t l = 0; l < surface.layer_areas().size(); ++l) {
    const LayerOptions& layer = organ.options().layers[l];
    Json& added = (*facts)["layers"].emplace_back(
        Json{{"area_m2", surface.layer_areas()[l]}, {"stiffness_N_per_m", layer.stiffness}});
    if (layer.strength) added["strength_N_per_m"] = *layer.strength;
  }
}

Json BedFacts(const AttachmentBed& bed, const Vector3d& borne_W) {
  return {{"name", bed.options.name},
          {"label", bed.options.label},
          {"a", bed.options.a},
          {"b", bed.options.b},
          {"leaf", bed.law.leaf},
          {"samples", bed.size()},
          {"area_m2", bed.areas.sum()},
          {"opens_at_m", bed.law.onset},
          {"free_at_m", bed.law.final},
          {"strength_N", bed.areas.sum() * bed.law.stiffness * bed.law.onset},
          {"bears_N", borne_W.norm()},
          {"work_to_free_J", bed.areas.sum() * bed.law.toughness}};
}

Json DuctFacts(const DuctModel& duct) {
  Json facts = {{"name", duct.options.name},           {"length_m", duct.rod.rest_length()},
                {"radius_m", duct.options.radius},     {"wall_m", duct.options.wall},
                {"segments", duct.rod.nodes() - 1},    {"axial_N", duct.section.axial},
                {"bending_N_m2", duct.section.bending}};
  if (!duct.options.a.empty()) facts["a"] = duct.options.a;
  if (!duct.options.b.empty()) facts["b"] = duct.options.b;
  if (!duct.options.label.empty()) facts["label"] = duct.options.label;
  return facts;
}

Json OrganFacts(const OrganModel& organ) {
  const Box bounds = AxisAlignedBounds(organ.rest().vertices);
  Json facts = {{"name", organ.options().name},
                {"mesh", organ.options().mesh},
                {"model", ModelName(organ.options().model)},
                {"vertices", organ.rest().vertices.rows()},
                {"triangles", organ.rest().triangles.rows()},
                {"tissue_volume_m3", organ.tissue_volume()},
                {"control_points", organ.control_points()},
                {"stiffness_regions", organ.options().regions.size()},
                {"supports", organ.options().supports.size()},
                {"box_min_m", Coordinates(bounds.min)},
                {"box_max_m", Coordinates(bounds.max)},
                {"held", SupportFacts(organ, bounds)}};
  if (const MaterialOptions& material = organ.options().material; material.prony.count > 0) {
    facts["young_Pa"] = material.young;
    facts["instantaneous_young_Pa"] = material.young * material.prony.InstantaneousFactor();
    for (int k = 0; k < material.prony.count; ++k) {
      const auto& [share, time] = material.prony.terms[static_cast<std::size_t>(k)];
      facts["prony"].push_back({{"share", share}, {"time_s", time}});
    }
  }
  if (organ.rigid()) return facts;
  // Number of coupled unknowns: one axis at a time (metric, continuum) or all three.
  double unknowns = organ.control_points();
  if (organ.lattice_organ() != nullptr) {
    AddSurfaceFacts(organ, &facts);
    const Lattice& lattice = organ.lattice_organ()->lattice();
    const Vector3d size = 1000 * lattice.box().lengths;
    facts["lattice_mm"] = {size.x(), size.y(), size.z()};
    const std::set<int> places(lattice.kept().begin(), lattice.kept().end());
    const int used = static_cast<int>(places.size());
    facts["control_points_dropped"] = lattice.basis().count() - used;
    facts["control_points_split"] =
        static_cast<int>(lattice.kept().size()) - used - lattice.front_functions();
    for (const Lattice& level : lattice.levels()) facts["levels"].push_back(level.size());
    if (const std::optional<double>& error = organ.lattice_organ()->error_of_levels()) {
      facts["error_of_levels"] = *error;
    }
    if (const CutSurfaces& cuts = organ.lattice_organ()->cuts(); cuts != nullptr) {
      facts["control_points_front"] = lattice.front_functions();
      const std::size_t planned = organ.options().cuts.size();
      for (std::size_t c = 0; c < planned; ++c) facts["cuts"].push_back(CutFacts((*cuts)[c]));
      facts["notches"] = cuts->size() - planned;
    }
    if (organ.options().energy.type == EnergyType::kStrain) unknowns *= 3;
    facts["cost"]["matrix_bytes"] = 8 * unknowns * unknowns;
    if (organ.refinement_basis() != nullptr) {
      facts["local_functions"] = LocalFunctionsOf(organ.options());
      facts["refinement_functions"] = organ.refinement_basis()->size();
      facts["cost"]["refinement_bytes"] = organ.refinement_basis()->Bytes();
      // Deprecated names of the two keys above.
      facts["local_candidates"] = organ.refinement_basis()->size();
      facts["cost"]["local_bytes"] = organ.refinement_basis()->Bytes();
    }
  } else if (organ.springs() != nullptr) {
    unknowns *= 3;
    facts["cost"]["springs"] = organ.springs()->springs().size();
    facts["cost"]["substeps"] = organ.springs()->substeps();
  } else {
    const auto& K = std::get<ScalarStiffness>(organ.stiffness());
    facts["cost"]["matrix_bytes"] = 12 * K.nonZeros();  // sparse: a value and its column
  }
  facts["cost"]["unknowns"] = unknowns;
  facts["cost"]["relocation_flops"] = 6.0 * static_cast<double>(organ.weights().nonZeros());
  return facts;
}

std::string Text(const Json& coordinates) {
  return Format("[%.3f, %.3f, %.3f]", coordinates[0].get<double>(), coordinates[1].get<double>(),
                coordinates[2].get<double>());
}

void PrintSupports(const Json& organ) {
  int number = 0;
  for (const Json& support : organ["held"]) {
    const std::string how =
        support.contains("stiffness_Pa_per_m2")
            ? Format("%.3g Pa/m^2", support["stiffness_Pa_per_m2"].get<double>())
            : "fixed";
    std::printf("  support[%d] (%s) holds %.3f l, %.0f %% of the tissue\n", number++, how.c_str(),
                1000 * support["tissue_volume_m3"].get<double>(),
                100 * support["share"].get<double>());
  }
}

void PrintOrgan(const Json& organ) {
  std::printf("organ %s: %ld vertices, %ld triangles, %.3f l of tissue\n",
              organ["name"].get<std::string>().c_str(), organ["vertices"].get<long>(),
              organ["triangles"].get<long>(), 1000 * organ["tissue_volume_m3"].get<double>());
  std::printf("  box from %s to %s m\n", Text(organ["box_min_m"]).c_str(),
              Text(organ["box_max_m"]).c_str());
  if (organ["model"] == "rigid") {
    std::printf("  rigid: a virtual wall; costs only collision\n");
    return;
  }
  if (organ.contains("lattice_mm")) {
    std::printf(
        "  lattice of %.0f x %.0f x %.0f mm, %ld control points (%ld without tissue dropped, "
        "%ld added at gaps in the tissue)\n",
        organ["lattice_mm"][0].get<double>(), organ["lattice_mm"][1].get<double>(),
        organ["lattice_mm"][2].get<double>(), organ["control_points"].get<long>(),
        organ["control_points_dropped"].get<long>(), organ["control_points_split"].get<long>());
    if (organ.contains("error_of_levels")) {
      std::string levels;
      for (const Json& functions : organ.value("levels", Json::array())) {
        levels += (levels.empty() ? "" : " + ") + std::to_string(functions.get<int>());
      }
      std::printf("  %s control points on finer levels, which could still change it by %.1f %%\n",
                  levels.empty() ? "no" : levels.c_str(),
                  100 * organ["error_of_levels"].get<double>());
    }
    for (const Json& cut : organ.value("cuts", Json::array())) {
      std::printf("  a cut of %.1f cm^2%s\n", 1e4 * cut["area_in_tissue_m2"].get<double>(),
                  cut["ends_in_tissue"].get<bool>() ? "" : ", right through the tissue");
    }
    if (organ.contains("notches")) {
      const long notches = organ["notches"].get<long>();
      if (notches > 0) {
        std::printf("  %ld narrow notch%s in the surface, like a cut without width\n", notches,
                    notches == 1 ? "" : "es");
      }
      std::printf("  %ld functions more where cuts end\n",
                  organ["control_points_front"].get<long>());
    }
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
  if (organ.contains("prony")) {
    std::printf("  viscoelastic: %.3g Pa at once, %.3g Pa in the end; %zu Prony term%s\n",
                organ["instantaneous_young_Pa"].get<double>(), organ["young_Pa"].get<double>(),
                organ["prony"].size(), organ["prony"].size() == 1 ? "" : "s");
  }
  for (const Json& lumen : organ.value("lumens", Json::array())) {
    std::printf("  a filled lumen of %.2f ml at %.3g Pa\n", 1e6 * lumen["volume_m3"].get<double>(),
                lumen["pressure_Pa"].get<double>());
  }
  for (const Json& layer : organ.value("layers", Json::array())) {
    std::printf("  a layer of %.1f cm^2, %.3g N/m\n", 1e4 * layer["area_m2"].get<double>(),
                layer["stiffness_N_per_m"].get<double>());
  }
  PrintSupports(organ);
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

void PrintBed(const Json& bed) {
  const auto name = bed["name"].get<std::string>(), a = bed["a"].get<std::string>(),
             b = bed["b"].get<std::string>();
  std::printf(
      "%s%s of %s and %s: %.1f cm^2 in %ld samples; it holds %.2f N, opens at %.2g mm, and is free "
      "at %.2g mm after %.2g mJ\n",
      bed["leaf"].get<bool>() ? "leaf" : "attachment", name.empty() ? "" : (" " + name).c_str(),
      a.c_str(), b.c_str(), 1e4 * bed["area_m2"].get<double>(), bed["samples"].get<long>(),
      bed["strength_N"].get<double>(), 1000 * bed["opens_at_m"].get<double>(),
      1000 * bed["free_at_m"].get<double>(), 1000 * bed["work_to_free_J"].get<double>());
  if (const double borne = bed["bears_N"].get<double>(); borne > 0) {
    std::printf("  it bears %.3f N of their weight at the start\n", borne);
  }
}

void PrintDuct(const Json& duct) {
  const auto end = [&](const char* key) {
    return duct.contains(key) ? duct[key].get<std::string>() : std::string("the world");
  };
  std::printf(
      "duct %s from %s to %s: %.3g mm long, %.3g mm wide, wall %.3g mm; EA %.3g N, EI %.3g N "
      "mm^2\n",
      duct["name"].get<std::string>().c_str(), end("a").c_str(), end("b").c_str(),
      1000 * duct["length_m"].get<double>(), 2000 * duct["radius_m"].get<double>(),
      1000 * duct["wall_m"].get<double>(), duct["axial_N"].get<double>(),
      1e6 * duct["bending_N_m2"].get<double>());
  if (duct.contains("label")) {
    std::printf("  its label: %s\n", duct["label"].get<std::string>().c_str());
  }
}

std::string_view TypeName(InstrumentType type) {
  for (const auto& [name, named] : kInstrumentTypes) {
    if (named == type) return name;
  }
  return "";
}

Json InstrumentFacts(const InstrumentOptions& instrument, const DeviceChoice& device,
                     const HandSite& site) {
  Json facts = {{"name", instrument.name},
                {"type", TypeName(instrument.type)},
                {"device", device.Text()},
                {"organ", instrument.hand.organ},
                {"target_m", Coordinates(site.p_target_W)},
                {"target_from_trocar_m", (site.p_target_W - site.p_trocar_W).norm()},
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
  std::printf("  the hand's target is %s on organ %s, %.0f mm from the trocar\n",
              Text(instrument["target_m"]).c_str(), text(instrument["organ"]).c_str(),
              1000 * instrument["target_from_trocar_m"].get<double>());
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
  const double stiffness = contact["stiffness_N_per_m"].get<double>();
  std::printf(
      "  on organ %s: at most %.*f N/m (%s); its device is passive to %.0f, stable to %.0f\n",
      contact["organ"].get<std::string>().c_str(), stiffness < 10 ? 2 : 0, stiffness,
      contact["axis"].get<std::string>().c_str(), contact["passive_to_N_per_m"].get<double>(),
      contact["stable_to_N_per_m"].get<double>());
}

// Facts of an instrument at a rigid organ.
Json WallFacts(const std::string& instrument, const OrganOptions& organ, const VirtualWall& wall) {
  const std::optional<double>& given = organ.wall_stiffness;
  return {{"instrument", instrument},
          {"organ", organ.name},
          {"given", given.has_value()},
          {"least_N_per_m", given.value_or(wall.least)},
          {"median_N_per_m", given.value_or(wall.median)},
          {"greatest_N_per_m", given.value_or(wall.greatest)},
          {"every_direction_to_N_per_m", wall.limit},
          {"least_at_m", Coordinates(wall.p_least_W)},
          {"lever_m", wall.lever},
          {"reachable", wall.reachable}};
}

void PrintWall(const Json& wall) {
  const std::string organ = wall["organ"].get<std::string>();
  const double least = wall["least_N_per_m"].get<double>();
  const double lever = 1000 * wall["lever_m"].get<double>();
  if (wall["given"].get<bool>()) {
    std::printf("  on organ %s: a wall of %.0f N/m, given; its device displays %.0f N/m stably\n",
                organ.c_str(), least, wall["every_direction_to_N_per_m"].get<double>());
  } else if (!wall["reachable"].get<bool>()) {
    std::printf("  on organ %s: out of reach; a wall of %.0f N/m along the shaft at %.0f mm\n",
                organ.c_str(), least, lever);
  } else {
    std::printf(
        "  on organ %s: a wall of %.0f to %.0f N/m along the normal, median %.0f; least %.0f mm "
        "from the trocar at %s\n",
        organ.c_str(), least, wall["greatest_N_per_m"].get<double>(),
        wall["median_N_per_m"].get<double>(), lever, Text(wall["least_at_m"]).c_str());
  }
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
    const InstrumentOptions& instrument = session.scene().instruments[i];
    facts["instruments"].push_back(
        InstrumentFacts(instrument, session.device_choices()[i], session.SiteOf(instrument)));
  }
  for (std::size_t l = 0; l < session.beds().size(); ++l) {
    facts["attachments"].push_back(BedFacts(session.beds()[l], session.borne_W()[l]));
  }
  for (const DuctModel& duct : session.ducts()) facts["ducts"].push_back(DuctFacts(duct));
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
    if (organ.lattice_organ() != nullptr && organ.options().energy.type == EnergyType::kMetric) {
      facts["remarks"].push_back(AccuracyOfMetric(organ.options().name));
    }
  }
  if (as_json) {
    std::cout << JsonText(facts) << "\n";
    return;
  }
  std::cout << facts["scene"].get<std::string>() << ": sound\n";
  for (const Json& organ : facts["organs"]) PrintOrgan(organ);
  if (facts.contains("attachments")) {
    for (const Json& bed : facts["attachments"]) PrintBed(bed);
  }
  if (facts.contains("ducts")) {
    for (const Json& duct : facts["ducts"]) PrintDuct(duct);
  }
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
  auto schema = std::make_shared<bool>(false);
  Command check = app.AddCommand("check", "Validate a scene and report what it builds and costs");
  check.AddOption("scene", *scene, "Scene file (TOML; see scenes/README.md)");
  const Option json = check.AddFlag("--json", *as_json, "Print JSON");
  check
      .AddFlag("--schema", *schema,
               "Print the JSON Schema of scene files, by which editors complete and check them")
      .Excludes("scene")
      .Excludes(json);
  check.OnRun([scene, as_json, schema] {
    if (*schema) {
      std::cout << SceneSchema();
    } else if (scene->empty()) {
      throw InputError("scene is required; see hpdm check --help");
    } else {
      Check(*scene, *as_json);
    }
  });
}

}  // namespace hpdm
