#include "engine/mesh/files/mesh_file.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>

#include "engine/mesh/files/mesh_file_formats.h"

namespace hpdm {
namespace {

/// Reads the whole file. Refuses it if it is not a regular file (a pipe never ends) or too large.
std::string ReadBytes(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    mesh_file::Refuse(path, "no such file; check the path of the mesh");
  }
  if (!std::filesystem::is_regular_file(path, error)) {
    mesh_file::Refuse(path, "not a regular file; name an OBJ, STL or PLY file");
  }
  const auto size = static_cast<std::int64_t>(std::filesystem::file_size(path, error));
  if (error || size > MeshFileLimits::kBytes) {
    mesh_file::Refuse(path, "larger than 1 GiB; reduce the mesh");
  }
  std::string bytes(static_cast<std::size_t>(size), '\0');
  std::ifstream stream(path, std::ios::binary);
  stream.read(bytes.data(), size);
  if (!stream) mesh_file::Refuse(path, "cannot be read; check its permissions");
  return bytes;
}

}  // namespace

MeshFile ReadMeshFile(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension != ".obj" && extension != ".stl" && extension != ".ply") {
    mesh_file::Refuse(path, "unknown kind of mesh file; convert it to .obj, .stl or .ply");
  }
  const std::string bytes = ReadBytes(path);
  if (bytes.empty()) mesh_file::Refuse(path, "the file is empty; export the mesh again");

  MeshFile file = extension == ".obj"   ? mesh_file::ReduceObj(bytes, path)
                  : extension == ".stl" ? mesh_file::ReduceStl(bytes, path)
                                        : mesh_file::ReducePly(bytes, path);
  if (file.faces == 0) {
    mesh_file::Refuse(path, "holds no faces; export the mesh as a surface of triangles");
  }
  return file;
}

}  // namespace hpdm
