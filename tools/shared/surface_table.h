#pragma once

#include <string>

#include "engine/base/types.h"

namespace hpdm {

/// Displacements of a surface as `hpdm solve` writes them and tests/reference stores them: CSV with
/// the header x,y,z,ux,uy,uz and a row per vertex, m.
struct SurfaceTable {
  Points positions;      ///< V x 3, at rest.
  Points displacements;  ///< V x 3.
};

/// Reads a table. Throws InputError (file, line, remedy).
SurfaceTable ReadSurfaceTable(const std::string& path);
void WriteSurfaceTable(const std::string& path, const SurfaceTable& table);

}  // namespace hpdm
