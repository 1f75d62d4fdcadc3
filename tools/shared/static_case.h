#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/mesh/surface_mesh.h"
#include "scenes/loader/scene.h"

namespace hpdm {

/// What a scene's loads ask to be solved: one organ at rest and what acts on it.
struct StaticCase {
  Scene scene;
  OrganOptions organ;  ///< The one that all loads act on.
  SurfaceMesh rest;    ///< Posed, world, m.
};

/// Throws InputError (file, remedy) for a bad scene, one without loads, and loads on several
/// organs.
StaticCase LoadStaticCase(const std::string& path);

/// Displacements of a reference (surface_table.h) for the vertices of `rest`, V x 3, m. Throws
/// InputError when the file is no surface table or is that of another mesh.
Points ReadReferenceDisplacements(const std::string& path, const SurfaceMesh& rest);

/// Linear tetrahedra on the same case, as the reference solution measured them.
struct LinearTetrahedra {
  int nodes = 0;
  bool graded = false;          ///< Finer towards the load.
  double error = 0;             ///< Area-weighted relative L2, as RelativeSurfaceError.
  double compliance_ratio = 0;  ///< Over the reference's.
};

/// A case's answer by quadratic tetrahedra (tests/reference/README.md).
struct CaseReference {
  Points displacements;                      ///< V x 3, m.
  double compliance = 0;                     ///< Of the first load, m/N.
  std::vector<Vector3d> load_displacements;  ///< m, one a load (none for a pressure).
  std::vector<LinearTetrahedra> linear;
};

/// Reads NAME.csv and NAME.json of the folder, NAME the scene file's name without .toml. Throws
/// InputError (file, remedy) when one is missing or of another form.
CaseReference LoadCaseReference(const StaticCase& load_case, const std::filesystem::path& folder);

/// NAME of a case: the scene file's name without its ending.
std::string CaseName(const StaticCase& load_case);

/// Whether the surface has a cavity: a closed part that faces inwards.
bool IsHollow(const SurfaceMesh& mesh);

}  // namespace hpdm
