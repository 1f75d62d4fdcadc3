#pragma once

#include <cstdint>
#include <string>

namespace hpdm {

/// Bounds on what a mesh file may hold; beyond them it is refused before anything is allocated for
/// it. At the bounds an import takes up to about 2 GB and a minute.
struct MeshFileLimits {
  static constexpr std::int64_t kBytes = std::int64_t{1} << 30;
  static constexpr std::int64_t kVertices = 10'000'000;
  static constexpr std::int64_t kCorners = 10'000'000;  ///< Of all faces together.
  static constexpr std::int64_t kFaceCorners = 256;     ///< Of one face.
};

/// A mesh file reduced to its geometry: vertex positions, texture coordinates and faces, written
/// anew in its own format without names, materials, references to other files, lines or points.
/// Every count was checked against the bytes, every face has 3 to kFaceCorners corners, every index
/// is in range and every number is finite, so that whatever reads `bytes` meets no surprise.
struct MeshFile {
  std::string format;  ///< "obj", "stl" (binary) or "ply" (binary, little-endian).
  std::string bytes;
  std::int64_t vertices = 0;    ///< STL: three a face.
  std::int64_t referenced = 0;  ///< Vertices that some face names.
  std::int64_t faces = 0;
  std::int64_t corners = 0;
};

/// Reads an OBJ, STL (text or binary) or PLY (text or binary) file, chosen by the extension in any
/// case. Numbers do not depend on the locale. Throws InputError (file, line or place, remedy) when
/// the file is missing, too large, of another kind, truncated, malformed, or without faces.
MeshFile ReadMeshFile(const std::string& path);

}  // namespace hpdm
