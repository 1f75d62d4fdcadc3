#include "tests/bad_input/meshes/mesh_faults.h"

#include <fstream>
#include <utility>

#include "tests/support/mesh_bytes.h"

namespace hpdm {

void MeshFaults::Add(std::string file, std::string bytes) {
  Add(std::move(file), [bytes = std::move(bytes)](const std::filesystem::path& path) {
    std::ofstream(path, std::ios::binary) << bytes;
  });
}

void MeshFaults::Add(const std::string& file, const SurfaceMesh& mesh) {
  const std::string ending = std::filesystem::path(file).extension();
  Add(file, ending == ".obj"   ? ObjText(mesh)
            : ending == ".stl" ? StlBytes(mesh)
                               : PlyBytes(PlyEncoding::kLittleEndian, mesh));
}

}  // namespace hpdm
