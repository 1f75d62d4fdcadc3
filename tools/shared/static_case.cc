#include "tools/shared/static_case.h"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "engine/base/error.h"
#include "engine/organ.h"
#include "engine/tissue/lumen.h"
#include "tools/shared/report_text.h"
#include "tools/shared/surface_table.h"
#include "tools/shared/with_scene_path.h"

namespace hpdm {
namespace {

// Tolerance relative to the organ's size. Files may round positions; another pose differs by more.
constexpr double kSamePlace = 1e-3;

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
  const OrganOptions& organ = *std::find_if(
      scene.organs.begin(), scene.organs.end(),
      [&](const OrganOptions& candidate) { return candidate.name == scene.loads[0].organ; });
  if (organ.model == OrganModelType::kRigid) {
    throw InputError(scene.path.string() + ": organ \"" + organ.name +
                     "\" is rigid: a load does not deform it; load another or change its model");
  }
  if (IsAttached(scene.attachments, organ.name)) {
    throw InputError(
        scene.path.string() + ": organ \"" + organ.name +
        "\": has an [[attachment]], which a static case of one organ leaves out; remove "
        "it, or run a session");
  }
  if (HoldsDuct(scene.ducts, organ.name)) {
    throw InputError(
        scene.path.string() + ": organ \"" + organ.name +
        "\": holds a [[duct]], which a static case of one organ leaves out; remove it, "
        "or run a session");
  }
  return organ;
}

std::vector<ComparedTetrahedra> ComparedIn(const nlohmann::json& facts) {
  std::vector<ComparedTetrahedra> compared;
  const auto add = [&](const nlohmann::json& meshes, bool quadratic) {
    for (const nlohmann::json& mesh : meshes) {
      compared.push_back({quadratic, mesh.at("nodes"), mesh.at("graded"), mesh.at("error"),
                          mesh.at("compliance_ratio")});
    }
  };
  add(facts.at("linear"), false);
  add(facts.value("quadratic", nlohmann::json::array()), true);
  return compared;
}

}  // namespace

StaticCase LoadStaticCase(const std::string& path) { return MakeStaticCase(LoadScene(path)); }

StaticCase MakeStaticCase(Scene scene) {
  StaticCase load_case;
  load_case.scene = std::move(scene);
  load_case.organ = LoadedOrgan(load_case.scene);
  std::vector<std::string> repairs;
  load_case.rest =
      WithScenePlace(load_case.scene, [&] { return LoadPosedMesh(load_case.organ, &repairs); });
  return load_case;
}

Points ReadReferenceDisplacements(const std::string& path, const SurfaceMesh& rest) {
  const SurfaceTable reference = ReadSurfaceTable(path);
  if (reference.positions.rows() != rest.vertices.rows()) {
    throw InputError(path + ": has " + std::to_string(reference.positions.rows()) +
                     " vertices, the organ " + std::to_string(rest.vertices.rows()) +
                     "; give the reference of the same mesh");
  }
  const double apart = (reference.positions - rest.vertices).rowwise().norm().maxCoeff();
  const double size =
      (rest.vertices.colwise().maxCoeff() - rest.vertices.colwise().minCoeff()).norm();
  if (!(apart <= kSamePlace * size)) {
    throw InputError(path + ": its vertices are off the organ's by up to " +
                     Format("%.1f", 1000 * apart) +
                     " mm; give the reference of the same mesh in the same pose");
  }
  return reference.displacements;
}

CaseReference LoadCaseReference(const StaticCase& load_case, const std::filesystem::path& folder) {
  const std::string name = CaseName(load_case);
  const std::string table = (folder / (name + ".csv")).string();
  const std::string facts = (folder / (name + ".json")).string();
  const std::string remedy = "; create it with hpdm_yardstick " + load_case.scene.path.string() +
                             ", or leave the case out";
  for (const std::string& file : {table, facts}) {
    std::error_code ignored;
    if (!std::filesystem::exists(file, ignored)) throw InputError(file + ": is missing" + remedy);
  }
  CaseReference reference;
  reference.displacements = ReadReferenceDisplacements(table, load_case.rest);
  std::ifstream file(facts);
  try {
    const nlohmann::json json = nlohmann::json::parse(file);
    reference.compliance = json.at("compliance_m_per_N");
    for (const nlohmann::json& load : json.value("loads", nlohmann::json::array())) {
      const nlohmann::json& u = load.at("displacement_m");
      reference.load_displacements.emplace_back(u.at(0), u.at(1), u.at(2));
    }
    reference.compared = ComparedIn(json);
  } catch (const nlohmann::json::exception& error) {
    throw InputError(facts + ": does not hold a reference solution (" + error.what() + ")" +
                     remedy);
  }
  return reference;
}

std::vector<ComparedTetrahedra> ComparedBeside(const std::filesystem::path& table) {
  std::ifstream file(std::filesystem::path(table).replace_extension(".json"));
  try {
    return ComparedIn(nlohmann::json::parse(file));
  } catch (const nlohmann::json::exception&) {
    return {};
  }
}

std::string KindOf(const ComparedTetrahedra& mesh) {
  return std::string(mesh.quadratic ? "quadratic" : "linear") + " tetrahedra" +
         (mesh.graded ? ", graded" : " of one size");
}

std::string CaseName(const StaticCase& load_case) { return load_case.scene.path.stem().string(); }

bool IsHollow(const SurfaceMesh& mesh) {
  const std::vector<bool> inner = TrianglesOfLumens(mesh);
  return std::ranges::find(inner, true) != inner.end();
}

void RequireTissueAlone(const OrganOptions& organ) {
  if (organ.lumens.empty() && organ.layers.empty()) return;
  throw InputError(
      "organ \"" + organ.name +
      "\": has a lumen or a layer, which the reference solution leaves out; remove it");
}

}  // namespace hpdm
