#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/mesh/surface_mesh.h"
#include "scenes/loader/scene.h"

namespace hpdm {

/// The static problem of a scene: one organ at rest and its loads.
struct StaticCase {
  Scene scene;
  OrganOptions organ;  ///< The organ that all loads act on.
  SurfaceMesh rest;    ///< Posed, world, m.
};

/// Loads a scene as a static problem. Throws InputError (file, remedy) for a bad scene, a scene
/// without loads, and loads on several organs.
StaticCase LoadStaticCase(const std::string& path);
/// The same of a scene that is loaded.
StaticCase MakeStaticCase(Scene scene);

/// Reads the displacements of a reference (surface_table.h) for the vertices of `rest`, V x 3, m.
/// Throws InputError if the file is not a surface table or belongs to another mesh.
Points ReadReferenceDisplacements(const std::string& path, const SurfaceMesh& rest);

/// Results of tetrahedra on the same case, measured with the reference solution.
struct ComparedTetrahedra {
  bool quadratic = false;  ///< Ten nodes an element, which hardly lock; else four.
  int nodes = 0;
  bool graded = false;          ///< Finer towards the load.
  double error = 0;             ///< Area-weighted relative L2, as RelativeSurfaceError.
  double compliance_ratio = 0;  ///< Compliance divided by the reference's.
};

/// Reads the results of tetrahedra from the facts (NAME.json) beside a reference table NAME.csv.
/// Returns none if that file is missing or holds no facts.
std::vector<ComparedTetrahedra> ComparedBeside(const std::filesystem::path& table);

/// Returns "linear tetrahedra of one size", "quadratic tetrahedra, graded" and the like.
std::string KindOf(const ComparedTetrahedra& mesh);

/// A case's solution by quadratic tetrahedra (tests/reference/README.md).
struct CaseReference {
  Points displacements;                      ///< V x 3, m.
  double compliance = 0;                     ///< At the first load, m/N.
  std::vector<Vector3d> load_displacements;  ///< m, one per load; absent for a pressure.
  std::vector<ComparedTetrahedra> compared;
};

/// Reads NAME.csv and NAME.json in `folder`, where NAME is CaseName(load_case). Throws InputError,
/// which names the file and a remedy, if one is missing or malformed.
CaseReference LoadCaseReference(const StaticCase& load_case, const std::filesystem::path& folder);

/// Returns the scene file's name without .toml.
std::string CaseName(const StaticCase& load_case);

/// True if the surface has a cavity: a closed part that faces inwards.
bool IsHollow(const SurfaceMesh& mesh);

/// Refuses an organ with fillings or layers (InputError), of which the reference solutions know
/// nothing.
void RequireTissueAlone(const OrganOptions& organ);

}  // namespace hpdm
