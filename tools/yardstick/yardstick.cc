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

void Regenerate(const std::string& scene, const std::string& folder,
                const std::vector<int>& quadratic, const std::vector<int>& linear,
                const std::vector<int>& graded) {
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
  const auto add = [&](const char* list, const Solved& s, bool is_graded) {
    Json entry = Facts(c, s);
    entry["graded"] = is_graded;
    entry["error"] = RelativeSurfaceError(c.rest, s.u, best.u);
    entry["compliance_ratio"] = s.solution.Compliance() / best.solution.Compliance();
    json[list].push_back(entry);
  };
  json["coarser_quadratic"] = Json::array();
  for (std::size_t i = 0; i + 1 < levels.size(); ++i) add("coarser_quadratic", levels[i], true);
  json["linear"] = Json::array();
  WriteCsv(folder + "/" + CaseName(c) + ".csv", c, best.u);
  const auto write = [&] {  // after each mesh: the larger ones take minutes
    std::ofstream file(folder + "/" + CaseName(c) + ".json");
    file << json.dump(2) << '\n';
    if (!file) throw InputError(folder + ": cannot be written; check the folder");
  };
  write();
  for (const int corners : linear) {
    add("linear", Solve(c, MeshOf(c, corners, Grading::kEven, 0.03)), false);
    write();
  }
  for (const int corners : graded) {
    add("linear", Solve(c, MeshOf(c, corners, Grading::kLoads, 0.03)), true);
    write();
  }
}

}  // namespace
}  // namespace hpdm

int main(int argc, char** argv) {
  CLI::App app("Solves cases with tetrahedral finite elements and writes their references");
  std::string scene, folder = "tests/reference";
  std::vector<int> quadratic = {2500, 4500, 8000}, linear = {1600, 4000}, graded = {7000};
  app.add_option("scene", scene, "Case (TOML)")->required();
  app.add_option("--out", folder, "Folder of CASE.csv and CASE.json");
  app.add_option("--quadratic", quadratic, "Corner nodes of the quadratic meshes, ascending")
      ->delimiter(',');
  app.add_option("--linear", linear, "Nodes of the even linear meshes")->delimiter(',');
  app.add_option("--graded", graded, "Nodes of the graded linear meshes")->delimiter(',');
  CLI11_PARSE(app, argc, argv);
  try {
    hpdm::Regenerate(scene, folder, quadratic, linear, graded);
  } catch (const hpdm::InputError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
  return 0;
}
