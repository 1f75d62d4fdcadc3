// hpdm_yardstick SCENE: solves a scene's static loads with tetrahedral finite elements and writes
// the reference that the real-time models are measured against.

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "engine/base/error.h"
#include "engine/baselines/surface_error.h"
#include "engine/mesh/mesh_facts.h"
#include "engine/reference_fem/tetra_fem.h"
#include "tools/shared/static_case.h"
#include "tools/yardstick/case_mesh.h"

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;

struct Solved {
  Points u;  // of the surface's vertices, V x 3, m
  TetraSolution solution;
  double volume_change = 0;
  Eigen::Index nodes = 0, elements = 0;
  double mesh_volume = 0;
  double seconds = 0;
};

Solved Solve(const StaticCase& c, const TetraMesh& mesh) {
  const auto start = std::chrono::steady_clock::now();
  const bool finite = c.organ.energy.strain == StrainMeasure::kFinite;
  const TetraBody body(mesh, c.organ.material,
                       finite ? TetraLaw::kNeoHookean : TetraLaw::kSmallStrain);
  const TetraProblem problem = MakeTetraProblem(body, c.rest, c.organ.supports, c.scene.loads);
  TetraSolveOptions options;
  options.load_steps = finite ? 4 : 1;
  Solved solved;
  solved.solution = SolveTetra(body, problem, options);
  if (!solved.solution.converged)
    throw InputError(CaseName(c) + ": no equilibrium; lower the load");
  solved.u = ApplyRows(PointRows(mesh, c.rest.vertices), solved.solution.u);
  solved.volume_change = body.VolumeChange(solved.solution.u);
  solved.nodes = mesh.nodes.rows();
  solved.elements = mesh.elements.rows();
  solved.mesh_volume = TetraVolume(mesh);
  solved.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  std::printf("%s: %s %ld nodes, %.1f s, %d Newton, %d iterations, compliance %.6g m/N\n",
              CaseName(c).c_str(), mesh.quadratic() ? "quadratic" : "linear",
              static_cast<long>(solved.nodes), solved.seconds, solved.solution.newton_iterations,
              solved.solution.solver_iterations, solved.solution.Compliance());
  std::fflush(stdout);
  return solved;
}

Json Facts(const StaticCase& c, const Solved& s) {
  Json json;
  json["nodes"] = s.nodes;
  json["tetrahedra"] = s.elements;
  json["mesh_volume_m3"] = s.mesh_volume;
  json["compliance_m_per_N"] = s.solution.Compliance();
  json["volume_change"] = s.volume_change;
  json["surface_volume_change"] = RelativeVolumeChange(c.rest, s.u);
  return json;
}

void WriteCsv(const std::string& path, const StaticCase& c, const Points& u) {
  std::FILE* file = std::fopen(path.c_str(), "w");
  if (file == nullptr) throw InputError(path + ": cannot be written; check the folder");
  std::fprintf(file, "x,y,z,ux,uy,uz\n");
  for (Eigen::Index v = 0; v < u.rows(); ++v) {
    std::fprintf(file, "%.6g,%.6g,%.6g,%.6g,%.6g,%.6g\n", c.rest.vertices(v, 0),
                 c.rest.vertices(v, 1), c.rest.vertices(v, 2), u(v, 0), u(v, 1), u(v, 2));
  }
  if (std::fclose(file) != 0) throw InputError(path + ": cannot be written; is the disk full?");
}

std::vector<double> AsVector(const Vector3d& v) { return {v[0], v[1], v[2]}; }

/// The nodes of the meshes that the real-time models are compared with.
struct ComparedMeshes {
  std::vector<int> linear = {1600, 4000};
  std::vector<int> graded = {4000, 7000};
  std::vector<int> quadratic = {4000};
};

/// A case's reference as it is written.
struct Written {
  StaticCase load_case;
  std::string folder;
  Json json;
  Points u;  // of the surface's vertices, V x 3, m

  std::string File(const char* extension) const {
    return folder + "/" + CaseName(load_case) + extension;
  }
  void Add(const char* list, const Solved& s, bool is_graded) {
    Json entry = Facts(load_case, s);
    entry["graded"] = is_graded;
    entry["error"] = RelativeSurfaceError(load_case.rest, s.u, u);
    entry["compliance_ratio"] = s.solution.Compliance() / json["compliance_m_per_N"].get<double>();
    json[list].push_back(entry);
  }
  void Write() const {
    std::ofstream file(File(".json"));
    file << json.dump(2) << '\n';
    if (!file) throw InputError(folder + ": cannot be written; check the folder");
  }
};

void AddCompared(const ComparedMeshes& meshes, Written* written) {
  const StaticCase& c = written->load_case;
  written->json["linear"] = Json::array();
  written->json["quadratic"] = Json::array();
  // Written after each mesh, because the larger ones take minutes.
  for (const int nodes : meshes.linear) {
    written->Add("linear", Solve(c, MeshOf(c, nodes, Grading::kEven, 0.03)), false);
    written->Write();
  }
  for (const int nodes : meshes.graded) {
    written->Add("linear", Solve(c, MeshOf(c, nodes, Grading::kLoads, 0.03)), true);
    written->Write();
  }
  for (const int nodes : meshes.quadratic) {
    // A quadratic mesh has about seven nodes a corner.
    written->Add("quadratic", Solve(c, Quadratic(MeshOf(c, nodes / 7, Grading::kLoads, 0.03))),
                 true);
    written->Write();
  }
}

/// Measures the compared meshes of a case whose reference is there.
void CompareAgain(const std::string& scene, const std::string& folder,
                  const ComparedMeshes& meshes) {
  Written written{LoadStaticCase(scene), folder, {}, {}};
  RequireTissueAlone(written.load_case.organ);
  written.u = LoadCaseReference(written.load_case, folder).displacements;
  std::ifstream file(written.File(".json"));
  written.json = Json::parse(file);
  AddCompared(meshes, &written);
}

void Regenerate(const std::string& scene, const std::string& folder,
                const std::vector<int>& quadratic, const ComparedMeshes& compared) {
  const StaticCase c = LoadStaticCase(scene);
  RequireTissueAlone(c.organ);
  std::vector<Solved> levels;
  for (const int corners : quadratic) {
    levels.push_back(Solve(c, Quadratic(MeshOf(c, corners, Grading::kLoadsAndSupports, 0.01))));
  }
  const Solved& best = levels.back();
  Json json;
  json["case"] = CaseName(c);
  json["elements"] =
      "quadratic tetrahedra, graded towards the loads and the borders of the supports";
  json["strain"] =
      c.organ.energy.strain == StrainMeasure::kFinite ? "finite, stable Neo-Hookean" : "small";
  json["error_measure"] =
      "area-weighted relative L2 of the surface vertices' displacement against the finest "
      "quadratic mesh";
  json["young_Pa"] = c.organ.material.young;
  json["poisson"] = c.organ.material.poisson;
  json["surface_vertices"] = c.rest.vertices.rows();
  json["surface_volume_m3"] = EnclosedVolume(c.rest.vertices, c.rest.triangles);
  json.update(Facts(c, best));
  json["largest_displacement_m"] = best.u.rowwise().norm().maxCoeff();
  json["loads"] = Json::array();
  for (std::size_t l = 0; l < c.scene.loads.size(); ++l) {
    json["loads"].push_back({{"force_N", AsVector(best.solution.forces[l])},
                             {"displacement_m", AsVector(best.solution.displacements[l])}});
  }
  json["coarser_quadratic"] = Json::array();
  Written written{c, folder, std::move(json), best.u};
  for (std::size_t i = 0; i + 1 < levels.size(); ++i) {
    written.Add("coarser_quadratic", levels[i], true);
  }
  WriteCsv(written.File(".csv"), c, best.u);
  written.Write();
  AddCompared(compared, &written);
}

}  // namespace
}  // namespace hpdm

int main(int argc, char** argv) {
  CLI::App app("Solves cases with tetrahedral finite elements and writes their references");
  std::string scene, folder = "tests/reference";
  std::vector<int> quadratic = {2500, 4500, 8000};
  hpdm::ComparedMeshes compared;
  bool keep = false;
  app.add_option("scene", scene, "Case (TOML)")->required();
  app.add_option("--out", folder, "Folder of CASE.csv and CASE.json");
  app.add_flag("--keep", keep, "Keep the reference; measure only the compared meshes");
  app.add_option("--quadratic", quadratic, "Corner nodes of the reference's meshes, ascending")
      ->delimiter(',');
  app.add_option("--linear", compared.linear, "Nodes of the even linear meshes")->delimiter(',');
  app.add_option("--graded", compared.graded, "Nodes of the graded linear meshes")->delimiter(',');
  app.add_option("--compared", compared.quadratic, "Nodes of the compared quadratic meshes")
      ->delimiter(',');
  CLI11_PARSE(app, argc, argv);
  try {
    keep ? hpdm::CompareAgain(scene, folder, compared)
         : hpdm::Regenerate(scene, folder, quadratic, compared);
  } catch (const hpdm::InputError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
  return 0;
}
