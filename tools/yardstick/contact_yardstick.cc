// hpdm_contact_yardstick: solves the contact of two soft bodies (touching_bodies.h) by quadratic
// tetrahedra and writes the reference that the engine's contact is measured against.

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "engine/baselines/surface_error.h"
#include "tools/shared/touching_bodies.h"

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;

struct Solved {
  std::array<Points, 2> u;  // of the surfaces' vertices, V x 3, m
  TetraContactSolution contact;
  Eigen::Index nodes = 0, elements = 0;
};

// Returns the faces that can touch: those near the other body, above or below.
std::vector<TetraFace> Zone(const TetraMesh& mesh, const TouchingBody& body, double side) {
  std::vector<TetraFace> zone;
  for (const TetraFace& face : BoundaryFaces(mesh)) {
    bool in = true;
    for (const int node : face) {
      const Vector3d p =
          (mesh.nodes.row(node).transpose() - body.centre).cwiseQuotient(body.half_axes);
      in = in && side * p.z() > 0.5 && std::abs(p.x()) < 0.72 && std::abs(p.y()) < 0.8;
    }
    if (in) zone.push_back(face);
  }
  return zone;
}

// `times`: bricks along an edge of the surfaces' bricks; below one for coarser ones.
Solved Solve(double times, const std::array<SurfaceMesh, 2>& surfaces,
             const TetraContactOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  std::array<int, 3> bricks = kTouchingBricks;
  for (int& each : bricks) each = static_cast<int>(std::lround(each * times));
  std::vector<TetraBody> bodies;
  Solved solved;
  for (std::size_t b = 0; b < 2; ++b) {
    TetraMesh mesh = Quadratic(TouchingMesh(kTouchingBodies[b], bricks));
    solved.nodes += mesh.nodes.rows();
    solved.elements += mesh.elements.rows();
    bodies.emplace_back(
        std::move(mesh),
        MaterialOptions{.young = kTouchingBodies[b].young, .poisson = kTouchingPoisson},
        TetraLaw::kSmallStrain);
  }
  std::vector<CondensedTetraBody> condensed;
  for (std::size_t b = 0; b < 2; ++b) {
    const OrganOptions organ = TouchingOptions(kTouchingBodies[b]);
    const TetraProblem problem = MakeTetraProblem(bodies[b], surfaces[b], organ.supports, {});
    condensed.emplace_back(bodies[b], problem,
                           Zone(bodies[b].mesh(), kTouchingBodies[b], b == 0 ? 1 : -1));
  }
  condensed[1].Move(Vector3d(0, 0, -kTouchingPress));
  solved.contact = SolveTetraContact(condensed[0], condensed[1], options);
  for (std::size_t b = 0; b < 2; ++b) {
    solved.u[b] = ApplyRows(PointRows(bodies[b].mesh(), surfaces[b].vertices), solved.contact.u[b]);
  }
  std::printf(
      "%ld nodes, %.0f s: %s after %d rounds, force %.5g N, area %.4g cm^2, penetration %.3g mm\n",
      static_cast<long>(solved.nodes),
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(),
      solved.contact.converged ? "converged" : "not converged", solved.contact.rounds,
      solved.contact.force_W.norm(), 1e4 * solved.contact.area,
      1e3 * solved.contact.largest_penetration);
  std::fflush(stdout);
  return solved;
}

Json Facts(const Solved& solved) {
  return {{"nodes", solved.nodes},
          {"tetrahedra", solved.elements},
          {"force_N",
           {solved.contact.force_W[0], solved.contact.force_W[1], solved.contact.force_W[2]}},
          {"area_m2", solved.contact.area},
          {"largest_penetration_m", solved.contact.largest_penetration}};
}

void Regenerate(const std::filesystem::path& folder) {
  std::array<SurfaceMesh, 2> surfaces;
  std::vector<int> nodes;
  for (std::size_t b = 0; b < 2; ++b) {
    surfaces[b] = TouchingSurface(TouchingMesh(kTouchingBodies[b], kTouchingBricks), &nodes);
  }
  std::vector<Solved> levels;
  for (const double times : {0.5, 0.75, 1.0}) levels.push_back(Solve(times, surfaces, {}));
  const Solved& best = levels.back();
  Json json;
  json["case"] = "touching_bodies";
  json["elements"] = "quadratic tetrahedra, small strain, contact at the deformed shape";
  json["error_measure"] =
      "area-weighted relative L2 of a surface's displacement against the finest mesh";
  json["press_m"] = kTouchingPress;
  json.update(Facts(best));
  const auto errors = [&](const Solved& solved) {
    Json list;
    for (std::size_t b = 0; b < 2; ++b)
      list.push_back(RelativeSurfaceError(surfaces[b], solved.u[b], best.u[b]));
    return list;
  };
  for (std::size_t l = 0; l + 1 < levels.size(); ++l) {
    Json coarser = Facts(levels[l]);
    coarser["errors"] = errors(levels[l]);
    json["coarser"].push_back(coarser);
  }
  const Solved soft = Solve(1, surfaces, {.penalty = 20});
  Json softer = Facts(soft);
  softer["errors"] = errors(soft);
  json["penalty_a_fifth"] = softer;
  std::ofstream(folder / "touching_bodies.json") << json.dump(2) << '\n';
  std::FILE* csv = std::fopen((folder / "touching_bodies.csv").c_str(), "w");
  if (csv == nullptr) {
    std::fprintf(stderr, "%s: cannot be written; check the folder\n", folder.c_str());
    return;
  }
  std::fprintf(csv, "x,y,z,ux,uy,uz\n");
  for (std::size_t b = 0; b < 2; ++b) {
    for (Eigen::Index v = 0; v < surfaces[b].vertices.rows(); ++v) {
      const auto p = surfaces[b].vertices.row(v);
      const auto u = best.u[b].row(v);
      std::fprintf(csv, "%.6g,%.6g,%.6g,%.6g,%.6g,%.6g\n", p[0], p[1], p[2], u[0], u[1], u[2]);
    }
  }
  std::fclose(csv);
}

}  // namespace
}  // namespace hpdm

int main(int argc, char** argv) {
  if (argc > 2) {
    std::fprintf(stderr, "usage: hpdm_contact_yardstick [FOLDER]\n");
    return 2;
  }
  hpdm::Regenerate(argc == 2 ? argv[1] : "tests/reference");
}
