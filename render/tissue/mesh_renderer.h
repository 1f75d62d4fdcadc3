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

/// V x 3, single precision, the graphics card's format.
using PointsF = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// Computes the unit normals of VertexNormals (engine/mesh/surface_mesh.h) in single precision.
/// `normals` is resized only if its size differs.
void VertexNormalsF(const PointsF& vertices, const Triangles& triangles, PointsF* normals);

/// True if every edge joins two triangles that run along it in opposite directions, and the surface
/// faces outwards. Then back faces are never visible from outside.
bool IsClosed(const SurfaceMesh& mesh);

/// A mesh cut open at every edge sharper than `crease` (rad, between the triangles' normals), which
/// keeps the edges of instruments sharp. Each triangle's corner has its own vertex (3 F). Its
/// normal is the area-weighted mean over the triangles around the corner that are within the angle.
struct CreasedMesh {
  SurfaceMesh mesh;
  PointsF normals;      ///< 3 F x 3.
  bool closed = false;  ///< IsClosed() of the uncut mesh.
};
CreasedMesh CutCreases(const SurfaceMesh& mesh, double crease);

/// One mesh on the graphics card. Indices and texture coordinates are constant; positions and
/// normals are replaced when the mesh deforms. Render thread only.
///
/// Inputs of the vertex shader:
///   0  position
///   1  normal, in the vertices' frame
///   2  SetOffset
///   3  texture coordinates; 0 without
///   4  SetHeat
///   5  SetRaw
/// A vertex on a seam of the texture is drawn once for each side (seams.h), with one normal.
///
/// The CPU computes a deforming mesh's normals (41 us for 11,200 triangles). A geometry pass would
/// need every vertex's neighbours, and with a software renderer it would run on the same cores.
class MeshRenderer {
 public:
  /// Takes a deforming mesh with smooth normals, at rest.
  explicit MeshRenderer(const SurfaceMesh& rest);
  /// Takes a rigid mesh with its own normals.
  explicit MeshRenderer(const CreasedMesh& creased);

  /// Moves the vertices (V x 3, m; V as at construction, anything else is a bug), recomputes the
  /// normals and uploads both. Allocates nothing.
  void SetVertices(const PointsF& vertices);

  /// Buffers of R x 3 floats for a deformation on the card (lattice_deformation.h) instead of
  /// SetVertices: the V vertices, followed by those that copies() repeats.
  const GlObject& positions() const { return position_buffer_; }
  const GlObject& normals() const { return normal_buffer_; }
  const std::vector<int>& copies() const { return copies_; }

  /// Sets a value for each vertex (V), input 4 of the vertex shader; 0 before the first call.
  void SetHeat(const std::vector<float>& values) { SetValues(4, values, &heat_buffer_); }
  /// Sets how raw the surface is at each vertex (V), input 5: 0 whole, as before the first call, up to
  /// 1 raw, up to 2 charred.
  void SetRaw(const std::vector<float>& values) { SetValues(5, values, &raw_buffer_); }

  /// Sets the mesh's levels (mesh_levels.h) and selects the drawn one. Level 0 is the mesh itself
  /// and the initial selection.
  void SetLevels(const std::vector<MeshLevel>& levels);
  void SelectLevel(int level) { level_ = static_cast<std::size_t>(level); }
  int level() const { return static_cast<int>(level_); }

  /// Sets the translation of the whole mesh (m), input 2 of the vertex shader.
  void SetOffset(const Eigen::Vector3f& offset) { offset_ = offset; }

  /// Draws the triangles with the current program. For a closed mesh it culls back faces, which
  /// saves a quarter of a frame's time on the software renderer.
  void Draw() const;

 private:
  void Upload(const PointsF& vertices);
  void CreateLayout(const Triangles& drawn);
  void ReplaceIndices(const std::vector<const Triangles*>& levels);
  void SetValues(unsigned input, const std::vector<float>& values, std::optional<GlObject>* buffer);
  const PointsF& WithCopies(const PointsF& values);

  bool closed_;
  Triangles triangles_;        // F x 3, over the V vertices
  Eigen::Index vertex_count_;  // V
  std::vector<int> copies_;    // SeamedMesh::copies
  // For each level, the first of its indices and their number.
  std::vector<std::pair<Eigen::Index, Eigen::Index>> ranges_;
  std::size_t level_ = 0;
  std::vector<float> values_;                         // R, scratch
  Eigen::Vector3f offset_ = Eigen::Vector3f::Zero();  // m
  PointsF normals_;                                   // V x 3
  PointsF with_copies_;                               // R x 3, scratch
  GlObject layout_{GlKind::kVertexArray};
  GlObject position_buffer_{GlKind::kBuffer};
  GlObject normal_buffer_{GlKind::kBuffer};
  GlObject coordinate_buffer_{GlKind::kBuffer};
  std::optional<GlObject> heat_buffer_, raw_buffer_;
  GlObject index_buffer_{GlKind::kBuffer};
};

}  // namespace hpdm
