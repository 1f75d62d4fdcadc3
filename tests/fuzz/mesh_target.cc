#include <algorithm>
#include <array>
#include <set>
#include <vector>

#include "engine/mesh/files/mesh_import.h"
#include "tests/fuzz/input_file.h"

namespace hpdm::fuzz {
namespace {

/// Checks the promises of mesh_import.h for any mesh.
void EnsureSound(const SurfaceMesh& mesh) {
  HPDM_ENSURE(mesh.triangles.rows() > 0);
  HPDM_ENSURE(mesh.vertices.allFinite());
  std::vector<bool> used(static_cast<std::size_t>(mesh.vertices.rows()));
  std::set<std::array<int, 3>> seen;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    std::array<int, 3> corners;
    for (int c = 0; c < 3; ++c) {
      const int v = mesh.triangles(t, c);
      HPDM_ENSURE(v >= 0 && v < mesh.vertices.rows());
      used[static_cast<std::size_t>(v)] = true;
      corners[static_cast<std::size_t>(c)] = v;
    }
    std::sort(corners.begin(), corners.end());
    HPDM_ENSURE(corners[0] != corners[1] && corners[1] != corners[2]);
    HPDM_ENSURE(seen.insert(corners).second);
  }
  HPDM_ENSURE(std::find(used.begin(), used.end(), false) == used.end());
  const Eigen::Index uv_rows = mesh.texture_coordinates.rows();
  HPDM_ENSURE(uv_rows == 0 || uv_rows == 3 * mesh.triangles.rows());
  HPDM_ENSURE(mesh.texture_coordinates.allFinite());
}

void EnsureCounts(const ImportedMesh& imported) {
  const MeshFacts facts = ComputeMeshFacts(imported.mesh);
  HPDM_ENSURE(facts.vertices == imported.mesh.vertices.rows());
  HPDM_ENSURE(facts.degenerate_triangles < facts.triangles);
  HPDM_ENSURE(facts.components > 0);
  for (const auto& [name, count] : imported.repairs.List()) HPDM_ENSURE(count > 0);
  HPDM_ENSURE(imported.as_read.triangles == facts.triangles +
                                                imported.repairs.degenerate_triangles +
                                                imported.repairs.duplicate_triangles);
}

/// The result needs no further repair, except the facing of flat patches, which rounding decides.
void EnsureMended(SurfaceMesh mesh) {
  const MeshRepairs again = RepairMesh(&mesh);
  HPDM_ENSURE(again.welded_vertices == 0);
  HPDM_ENSURE(again.degenerate_triangles == 0);
  HPDM_ENSURE(again.duplicate_triangles == 0);
  HPDM_ENSURE(again.unreferenced_vertices == 0);
}

bool Import(const InputFile& file, Bytes bytes) {
  file.Write(bytes);
  try {
    const ImportedMesh imported = ImportMesh(file.path(), 1);
    EnsureSound(imported.mesh);
    EnsureCounts(imported);
    EnsureMended(imported.mesh);
    return true;
  } catch (const InputError& error) {
    EnsureOneLine(error, file.path());
    return false;
  }
}

}  // namespace

bool MeshObj(Bytes bytes) {
  static const InputFile file("mesh.obj");
  return Import(file, bytes);
}

bool MeshPly(Bytes bytes) {
  static const InputFile file("mesh.ply");
  return Import(file, bytes);
}

bool MeshStl(Bytes bytes) {
  static const InputFile file("mesh.stl");
  return Import(file, bytes);
}

}  // namespace hpdm::fuzz
