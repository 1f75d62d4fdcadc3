#pragma once

#include <string>

#include "engine/mesh/mesh_facts.h"
#include "engine/mesh/mesh_repair.h"
#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// An imported mesh. Indices are in range, coordinates finite, triangles distinct and consistently
/// oriented, their corners distinct, and every vertex is used. The mesh may still be open or have
/// needles (mesh_facts.h).
struct ImportedMesh {
  SurfaceMesh mesh;     ///< m; all meshes of the file merged, polygons triangulated.
  MeshFacts as_read;    ///< Facts of the file before the repairs; m.
  MeshRepairs repairs;  ///< Repairs that were made.
};

/// Reads an OBJ, STL or PLY file (selected by its extension) and scales it to metres.
///
/// 1. Coordinates keep the 24 bits of a float: 10 nm on a liver.
/// 2. The repairs (mesh_repair.h) also weld vertices that STL files or per-corner texture
///    coordinates repeat. So the vertices and their order do not depend on the texture coordinates.
///    MeshRepairs counts the repeated corners of an STL file as welded vertices.
/// 3. MeshFileLimits bounds time and memory, whatever counts the file claims.
/// 4. The result does not depend on the locale.
///
/// Throws InputError with one line (file, place, remedy).
ImportedMesh ImportMesh(const std::string& path, double metres_per_unit);

}  // namespace hpdm
