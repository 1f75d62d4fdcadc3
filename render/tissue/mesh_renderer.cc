#include "render/tissue/mesh_renderer.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>
#include <vector>

#include "engine/base/check.h"
#include "engine/mesh/mesh_edges.h"
#include "engine/mesh/vertex_normals.h"
#include "render/tissue/mesh_levels.h"

namespace hpdm {
namespace {

void SetInput(GLuint index, const GlObject& buffer, int components) {
  glBindBuffer(GL_ARRAY_BUFFER, buffer.name());
  glVertexAttribPointer(index, components, GL_FLOAT, GL_FALSE, 0, nullptr);
  glEnableVertexAttribArray(index);
}

/// Allocates new storage each time, so that the driver need not wait for the last frame's.
template <typename Matrix>
void Replace(const GlObject& buffer, const Matrix& values) {
  glBindBuffer(GL_ARRAY_BUFFER, buffer.name());
  glBufferData(GL_ARRAY_BUFFER,
               static_cast<GLsizeiptr>(values.size()) * static_cast<GLsizeiptr>(sizeof(float)),
               values.data(), GL_STREAM_DRAW);
}

}  // namespace

void VertexNormalsF(const PointsF& vertices, const Triangles& triangles, PointsF* normals) {
  SetVertexNormals(vertices, triangles, normals);
}

bool IsClosed(const SurfaceMesh& mesh) {
  bool closed = true;
  ForEachEdge(SortedEdgeUses(mesh.triangles), [&closed](auto first, auto last) {
    closed = closed && last - first == 2 && first->forward != std::next(first)->forward;
  });
  return closed && EnclosedVolume(mesh.vertices, mesh.triangles) > 0;
}

CreasedMesh CutCreases(const SurfaceMesh& mesh, double crease) {
  const Eigen::Index face_count = mesh.triangles.rows();
  Points face_normals(face_count, 3);  // twice the area long
  std::vector<std::vector<int>> faces_of(static_cast<std::size_t>(mesh.vertices.rows()));
  for (Eigen::Index t = 0; t < face_count; ++t) {
    const Vector3d a = mesh.vertices.row(mesh.triangles(t, 0));
    const Vector3d b = mesh.vertices.row(mesh.triangles(t, 1));
    const Vector3d c = mesh.vertices.row(mesh.triangles(t, 2));
    face_normals.row(t) = (b - a).cross(c - a);
    for (int corner = 0; corner < 3; ++corner) {
      faces_of[mesh.triangles(t, corner)].push_back(static_cast<int>(t));
    }
  }

  CreasedMesh creased;
  creased.closed = IsClosed(mesh);
  creased.mesh.vertices.resize(3 * face_count, 3);
  creased.mesh.triangles.resize(face_count, 3);
  creased.normals.resize(3 * face_count, 3);
  for (Eigen::Index t = 0; t < face_count; ++t) {
    const Vector3d own = face_normals.row(t).transpose().normalized();
    for (int corner = 0; corner < 3; ++corner) {
      const int vertex = mesh.triangles(t, corner);
      Vector3d sum = Vector3d::Zero();
      for (const int other : faces_of[vertex]) {
        const Vector3d normal = face_normals.row(other);
        if (own.dot(normal.normalized()) >= std::cos(crease)) sum += normal;
      }
      const Eigen::Index row = 3 * t + corner;
      creased.mesh.vertices.row(row) = mesh.vertices.row(vertex);
      creased.mesh.triangles(t, corner) = static_cast<int>(row);
      creased.normals.row(row) = sum.normalized().cast<float>();
    }
  }
  return creased;
}

MeshRenderer::MeshRenderer(const SurfaceMesh& rest)
    : closed_(IsClosed(rest)), triangles_(rest.triangles), vertex_count_(rest.vertices.rows()) {
  const SeamedMesh seamed = CutSeams(rest);
  copies_ = seamed.copies;
  const PointsF vertices = rest.vertices.cast<float>();
  VertexNormalsF(vertices, triangles_, &normals_);
  Replace(coordinate_buffer_, seamed.texture_coordinates);
  Upload(vertices);
  CreateLayout(seamed.triangles);
}

MeshRenderer::MeshRenderer(const CreasedMesh& creased)
    : closed_(creased.closed),
      triangles_(creased.mesh.triangles),
      vertex_count_(creased.mesh.vertices.rows()),
      normals_(creased.normals) {
  const PointsF vertices = creased.mesh.vertices.cast<float>();
  Replace(coordinate_buffer_, CutSeams(creased.mesh).texture_coordinates);
  Upload(vertices);
  CreateLayout(triangles_);
}

void MeshRenderer::CreateLayout(const Triangles& drawn) {
  glBindVertexArray(layout_.name());
  SetInput(0, position_buffer_, 3);
  SetInput(1, normal_buffer_, 3);
  SetInput(3, coordinate_buffer_, 2);
  glBindVertexArray(0);
  ReplaceIndices({&drawn});
}

void MeshRenderer::ReplaceIndices(const std::vector<const Triangles*>& levels) {
  Eigen::Index count = 0;
  ranges_.clear();
  for (const Triangles* level : levels) {
    ranges_.emplace_back(count, level->size());
    count += level->size();
  }
  const auto bytes = [](Eigen::Index indices) {
    return static_cast<GLsizeiptr>(indices) * static_cast<GLsizeiptr>(sizeof(int));
  };
  glBindVertexArray(layout_.name());
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, index_buffer_.name());
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, bytes(count), nullptr, GL_STATIC_DRAW);
  for (std::size_t i = 0; i < levels.size(); ++i) {
    glBufferSubData(GL_ELEMENT_ARRAY_BUFFER, bytes(ranges_[i].first), bytes(ranges_[i].second),
                    levels[i]->data());
  }
  glBindVertexArray(0);
}

void MeshRenderer::SetLevels(const std::vector<MeshLevel>& levels) {
  HPDM_CHECK(!levels.empty() && levels[0].triangles.size() == triangles_.size());
  std::vector<const Triangles*> drawn;
  for (const MeshLevel& level : levels) drawn.push_back(&level.triangles);
  ReplaceIndices(drawn);
}

const PointsF& MeshRenderer::WithCopies(const PointsF& values) {
  if (copies_.empty()) return values;
  const auto copy_count = static_cast<Eigen::Index>(copies_.size());
  with_copies_.resize(vertex_count_ + copy_count, 3);
  with_copies_.topRows(vertex_count_) = values;
  for (Eigen::Index c = 0; c < copy_count; ++c) {
    with_copies_.row(vertex_count_ + c) = values.row(copies_[c]);
  }
  return with_copies_;
}

void MeshRenderer::Upload(const PointsF& vertices) {
  Replace(position_buffer_, WithCopies(vertices));
  Replace(normal_buffer_, WithCopies(normals_));
}

void MeshRenderer::SetVertices(const PointsF& vertices) {
  HPDM_CHECK(vertices.rows() == vertex_count_);
  VertexNormalsF(vertices, triangles_, &normals_);
  Upload(vertices);
}

void MeshRenderer::SetValues(unsigned input, const std::vector<float>& values,
                             std::optional<GlObject>* buffer) {
  HPDM_CHECK(static_cast<Eigen::Index>(values.size()) == vertex_count_);
  values_ = values;
  for (const int copied : copies_) values_.push_back(values[static_cast<std::size_t>(copied)]);
  const bool first = !buffer->has_value();
  if (first) buffer->emplace(GlKind::kBuffer);
  Replace(**buffer, Eigen::Map<const Eigen::VectorXf>(values_.data(),
                                                      static_cast<Eigen::Index>(values_.size())));
  if (!first) return;
  glBindVertexArray(layout_.name());
  SetInput(input, **buffer, 1);
  glBindVertexArray(0);
}

void MeshRenderer::Draw() const {
  if (closed_) glEnable(GL_CULL_FACE);
  glVertexAttrib3fv(2, offset_.data());
  glBindVertexArray(layout_.name());
  const auto& [first, count] = ranges_[level_];
  glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(count), GL_UNSIGNED_INT,
                 reinterpret_cast<const void*>(static_cast<std::size_t>(first) * sizeof(int)));
  glDisable(GL_CULL_FACE);
}

}  // namespace hpdm
