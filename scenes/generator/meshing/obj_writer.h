#pragma once

#include <filesystem>
#include <string>

#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// A mesh as Wavefront OBJ text: `comment` (lines without '#'), then vertices in metres to the
/// micrometre, texture coordinates (each one once, to 1e-5) and triangles. The same mesh gives the
/// same bytes.
std::string ObjText(const SurfaceMesh& mesh, const std::string& comment);

/// Writes a text file; throws InputError (path and remedy) when that fails.
void WriteTextFile(const std::filesystem::path& path, const std::string& text);

}  // namespace hpdm
