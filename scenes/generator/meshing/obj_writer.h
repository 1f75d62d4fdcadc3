#pragma once

#include <filesystem>
#include <string>

#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// Returns a mesh as Wavefront OBJ text: `comment` (lines without '#'), vertices in metres to the
/// micrometre, texture coordinates (each one once, to 1e-5) and triangles. The same mesh gives the
/// same bytes.
std::string ObjText(const SurfaceMesh& mesh, const std::string& comment);

/// Writes a text file. Throws InputError (path and remedy) on failure.
void WriteTextFile(const std::filesystem::path& path, const std::string& text);

}  // namespace hpdm
