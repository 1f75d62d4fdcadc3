#pragma once

#include <Eigen/Core>
#include <optional>
#include <utility>
#include <vector>

#include "engine/mesh/surface_mesh.h"
#include "render/gl/gl_object.h"
#include "render/tissue/seams.h"

namespace hpdm {

struct MeshLevel;

/// V x 3, single precision, as the graphics card takes them.
using PointsF = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// Unit normals of the vertices as VertexNormals (engine/mesh/surface_mesh.h) gives them, in single
/// precision. `normals` is resized only when its size differs.
void VertexNormalsF(const PointsF& vertices, const Triangles& triangles, PointsF* normals);

/// Whether every edge joins two triangles that run along it in opposite directions, and the
/// surface faces outwards: then no triangle seen from behind is ever visible from outside.
bool IsClosed(const SurfaceMesh& mesh);

/// The mesh with every edge sharper than `crease` (rad, between the triangles' normals) cut open:
/// one vertex a triangle's corner (3 F) with a normal averaged, weighted by area, over the
/// triangles around the corner that are within the angle. Instruments keep their edges with it.
struct CreasedMesh {
  SurfaceMesh mesh;
  PointsF normals;      ///< 3 F x 3.
  bool closed = false;  ///< IsClosed of the mesh before the cuts.
};
CreasedMesh CutCreases(const SurfaceMesh& mesh, double crease);

/// One mesh on the graphics card: indices and texture coordinates stay, positions and normals are
/// replaced when the mesh deforms. Render thread only.
///
/// Inputs of the vertex shader: 0 position, 1 normal (in the frame the vertices are given in), 2
/// SetOffset, 3 texture coordinates (0 without), 4 SetHeat. Vertices on a seam of the texture are
/// drawn once a side of it (seams.h), with one normal.
///
/// Normals of a deforming mesh are computed here on the CPU (41 us for 11,200 triangles): with a
/// software renderer a geometry pass runs on the same cores, and needs every vertex's neighbours.
class MeshRenderer {
 public:
  /// A deforming mesh: smooth normals. Starts at rest.
  explicit MeshRenderer(const SurfaceMesh& rest);
  /// A rigid mesh with its own normals.
  explicit MeshRenderer(const CreasedMesh& creased);

  /// Moves the vertices (V x 3, m; V as at construction, anything else is a bug), recomputes the
  /// normals and uploads both. Allocates nothing.
  void SetVertices(const PointsF& vertices);

  /// Buffers of R x 3 floats, for a deformation on the card (lattice_deformation.h) instead of
  /// SetVertices: of the V vertices, then of those that copies() repeats.
  const GlObject& positions() const { return position_buffer_; }
  const GlObject& normals() const { return normal_buffer_; }
  const std::vector<int>& copies() const { return copies_; }

  /// A value a vertex (V), input 4 of the vertex shader; 0 before the first.
  void SetHeat(const std::vector<float>& values);

  /// Levels (mesh_levels.h) of this mesh to draw in place of all of its triangles, and which of
  /// them is drawn; their first is the mesh itself, which is drawn at the start.
  void SetLevels(const std::vector<MeshLevel>& levels);
  void SelectLevel(int level) { level_ = static_cast<std::size_t>(level); }
  int level() const { return static_cast<int>(level_); }

  /// By how much all of it is drawn away from its vertices (m), input 2 of the vertex shader.
  void SetOffset(const Eigen::Vector3f& offset) { offset_ = offset; }

  /// Draws the triangles with the program in use; of a closed mesh only those that face the
  /// viewer, which takes a quarter off a frame of the software renderer.
  void Draw() const;

 private:
  void Upload(const PointsF& vertices);
  void CreateLayout(const Triangles& drawn);
  void ReplaceIndices(const std::vector<const Triangles*>& levels);
  const PointsF& WithCopies(const PointsF& values);

  bool closed_;
  Triangles triangles_;        // F x 3, over the V vertices
  Eigen::Index vertex_count_;  // V
  std::vector<int> copies_;    // SeamedMesh::copies
  // Of each level, where its indices begin and how many they are.
  std::vector<std::pair<Eigen::Index, Eigen::Index>> ranges_;
  std::size_t level_ = 0;
  std::vector<float> heat_;                           // R, scratch
  Eigen::Vector3f offset_ = Eigen::Vector3f::Zero();  // m
  PointsF normals_;                                   // V x 3
  PointsF with_copies_;                               // R x 3, scratch
  GlObject layout_{GlKind::kVertexArray};
  GlObject position_buffer_{GlKind::kBuffer};
  GlObject normal_buffer_{GlKind::kBuffer};
  GlObject coordinate_buffer_{GlKind::kBuffer};
  std::optional<GlObject> heat_buffer_;
  GlObject index_buffer_{GlKind::kBuffer};
};

}  // namespace hpdm
