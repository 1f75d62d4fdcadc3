#pragma once

#include <string>

#include "engine/mesh/mesh_facts.h"
#include "engine/mesh/mesh_repair.h"
#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// A mesh as imported: sound (indices in range, finite, no triangle with equal corners, none
/// twice, no unused vertex, consistently oriented), but perhaps open or with needles
/// (mesh_facts.h tells).
struct ImportedMesh {
  SurfaceMesh mesh;     ///< m; every mesh of the file merged, polygons triangulated.
  MeshFacts as_read;    ///< What the file holds, before the repairs; m.
  MeshRepairs repairs;  ///< What had to be mended.
};

/// Reads an OBJ, STL or PLY file (chosen by its extension) and scales it to metres. Coordinates
/// keep the 24 bits of a float: 10 nm on a liver. The welding that STL and per-corner texture
/// coordinates need is done with the rest of the repairs (mesh_repair.h), so that the vertices and
/// their order do not depend on the texture coordinates; corners that an STL repeats count as
/// welded vertices. Time and memory are bounded by MeshFileLimits, whatever the file claims; the
/// result does not depend on the locale. Throws InputError with one line (file, place, remedy).
ImportedMesh ImportMesh(const std::string& path, double metres_per_unit);

}  // namespace hpdm
