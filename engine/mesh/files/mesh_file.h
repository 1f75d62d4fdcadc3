#pragma once

#include <cstdint>
#include <string>

namespace hpdm {

/// Bounds on the contents of a mesh file. A file beyond them is refused before memory is allocated
/// for it. At the bounds an import takes up to about 2 GB and a minute.
struct MeshFileLimits {
  static constexpr std::int64_t kBytes = std::int64_t{1} << 30;
  static constexpr std::int64_t kVertices = 10'000'000;
  static constexpr std::int64_t kCorners = 10'000'000;  ///< Corners of all faces together.
  static constexpr std::int64_t kFaceCorners = 256;     ///< Corners of one face.
};

/// A mesh file reduced to its geometry (vertex positions, texture coordinates, faces) and rewritten
/// in its own format. Names, materials, references to other files, lines and points are dropped.
/// `bytes` is safe to parse. Every count agrees with the bytes, every face has 3 to kFaceCorners
/// corners, every index is in range and every number is finite.
struct MeshFile {
  std::string format;  ///< "obj", "stl" (binary) or "ply" (binary, little-endian).
  std::string bytes;
  std::int64_t vertices = 0;    ///< STL: three for each face.
  std::int64_t referenced = 0;  ///< Vertices that a face uses.
  std::int64_t faces = 0;
  std::int64_t corners = 0;
};

/// Reads an OBJ, STL (text or binary) or PLY (text or binary) file. The extension, in upper or
/// lower case, selects the format. Numbers do not depend on the locale. Throws InputError (file,
/// line or place, remedy) if the file is missing, too large, of another kind, truncated, malformed,
/// or has no faces.
MeshFile ReadMeshFile(const std::string& path);

}  // namespace hpdm
