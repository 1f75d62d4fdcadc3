#include "engine/mesh/files/mesh_import.h"

#include <assimp/scene.h>

#include <array>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstdint>
#include <vector>

#include "engine/mesh/files/mesh_file_formats.h"
#include "engine/mesh/polygon.h"

namespace hpdm {
namespace {

using mesh_file::Refuse;

/// The triangles of all meshes of a file, corner by corner.
struct Corners {
  std::vector<std::array<int, 3>> vertices;                ///< One entry for each triangle.
  std::vector<std::array<double, 2>> texture_coordinates;  ///< Three entries for each triangle.
};

void CopyVertices(const aiMesh& part, Eigen::Index base, Points* vertices) {
  for (unsigned v = 0; v < part.mNumVertices; ++v) {
    const aiVector3D& p = part.mVertices[v];
    vertices->row(base + v) << p.x, p.y, p.z;
  }
}

/// Appends the triangles of one part. Splits polygons itself, because assimp's triangulation takes
/// cubic time, leaves holes in polygons that it cannot split, and aborts on unexpected meshes.
void CopyFaces(const aiMesh& part, Eigen::Index base, const Points& vertices, Corners* corners) {
  const auto add = [&](const aiFace& face, const std::array<int, 3>& t) {
    std::array<int, 3>& triangle = corners->vertices.emplace_back();
    for (std::size_t c = 0; c < 3; ++c) {
      const unsigned v = face.mIndices[t[c]];
      triangle[c] = static_cast<int>(base) + static_cast<int>(v);
      const aiVector3D uv = part.HasTextureCoords(0) ? part.mTextureCoords[0][v] : aiVector3D();
      corners->texture_coordinates.push_back({uv.x, uv.y});
    }
  };
  Points outline;
  for (unsigned f = 0; f < part.mNumFaces; ++f) {
    const aiFace& face = part.mFaces[f];
    const int count = static_cast<int>(face.mNumIndices);
    if (count == 3) {
      add(face, {0, 1, 2});
      continue;
    }
    outline.resize(count, 3);
    for (int c = 0; c < count; ++c) {
      outline.row(c) = vertices.row(base + static_cast<Eigen::Index>(face.mIndices[c]));
    }
    for (const std::array<int, 3>& t : TriangulatePolygon(outline)) add(face, t);
  }
}

/// Compares assimp's result with the counts of the file, so a partly read file is not taken for a
/// mesh.
void CheckAgainst(const MeshFile& file, const aiScene& scene, const std::string& path) {
  std::int64_t faces = 0, corners = 0;
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& part = *scene.mMeshes[m];
    faces += part.mNumFaces;
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      const aiFace& face = part.mFaces[f];
      corners += face.mNumIndices;
      for (unsigned c = 0; c < face.mNumIndices; ++c) {
        if (face.mIndices[c] >= part.mNumVertices) {
          Refuse(path, "a face names a vertex that does not exist; export the mesh again");
        }
      }
    }
  }
  if (faces != file.faces || corners != file.corners) {
    Refuse(path, "was read only in part; convert it to another of .obj, .stl and .ply");
  }
}

SurfaceMesh Merge(const aiScene& scene) {
  Eigen::Index vertex_count = 0;
  bool textured = false;
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    vertex_count += scene.mMeshes[m]->mNumVertices;
    textured = textured || scene.mMeshes[m]->HasTextureCoords(0);
  }
  SurfaceMesh mesh;
  mesh.vertices.resize(vertex_count, 3);
  Corners corners;
  Eigen::Index base = 0;
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& part = *scene.mMeshes[m];
    CopyVertices(part, base, &mesh.vertices);
    CopyFaces(part, base, mesh.vertices, &corners);
    base += part.mNumVertices;
  }
  const auto triangle_count = static_cast<Eigen::Index>(corners.vertices.size());
  mesh.triangles.resize(triangle_count, 3);
  mesh.texture_coordinates.resize(textured ? 3 * triangle_count : 0, 2);
  for (Eigen::Index t = 0; t < triangle_count; ++t) {
    for (int c = 0; c < 3; ++c) mesh.triangles(t, c) = corners.vertices[ToSize(t)][ToSize(c)];
  }
  for (Eigen::Index row = 0; row < mesh.texture_coordinates.rows(); ++row) {
    for (int d = 0; d < 2; ++d) {
      mesh.texture_coordinates(row, d) = corners.texture_coordinates[ToSize(row)][ToSize(d)];
    }
  }
  return mesh;
}

SurfaceMesh ReadWithAssimp(const MeshFile& file, const std::string& path) {
  Assimp::Importer importer;  // logs nothing, because no logger is created
  const aiScene* scene =
      importer.ReadFileFromMemory(file.bytes.data(), file.bytes.size(), 0, file.format.c_str());
  if (scene == nullptr) {
    Refuse(path, "cannot be read; convert it to another of .obj, .stl and .ply");
  }
  CheckAgainst(file, *scene, path);
  return Merge(*scene);
}

}  // namespace

ImportedMesh ImportMesh(const std::string& path, double metres_per_unit) {
  if (!(metres_per_unit > 0) || !std::isfinite(metres_per_unit)) {
    Refuse(path, "the unit must be a positive number of metres; give m, mm or metres per unit");
  }
  const MeshFile file = ReadMeshFile(path);
  ImportedMesh imported;
  imported.mesh = ReadWithAssimp(file, path);
  // The repairs work in the file's own unit, so their result does not depend on the unit.
  JoinIdenticalVertices(&imported.mesh);
  const auto joined = imported.mesh.vertices.rows();
  const MeshFacts as_read = ComputeMeshFacts(imported.mesh);
  imported.repairs = RepairMesh(&imported.mesh);
  if (file.format != "stl") {
    imported.repairs.welded_vertices += static_cast<int>(file.referenced - joined);
    imported.repairs.unreferenced_vertices += static_cast<int>(file.vertices - file.referenced);
  }
  const MeshFacts facts = ComputeMeshFacts(imported.mesh);
  if (facts.degenerate_triangles == facts.triangles) {
    Refuse(path, "has no triangle with an area; export the mesh again");
  }
  if (2 * imported.repairs.degenerate_triangles > as_read.triangles) {
    Refuse(path, std::to_string(imported.repairs.degenerate_triangles) + " of its " +
                     std::to_string(as_read.triangles) +
                     " triangles have corners that are one in the precision of the file; move the "
                     "mesh nearer to its origin or export it again");
  }
  imported.mesh.vertices *= metres_per_unit;
  imported.as_read = Scaled(as_read, metres_per_unit);
  if (!imported.mesh.vertices.allFinite()) {
    Refuse(path, "coordinates overflow in metres; check the unit");
  }
  return imported;
}

}  // namespace hpdm
