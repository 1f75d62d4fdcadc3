#include "engine/step/press_normal.h"

#include "engine/step/tip_contact.h"

namespace hpdm {
namespace {

Matrix3d CrossMatrix(const Vector3d& a) {
  return (Matrix3d() << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0).finished();
}

}  // namespace

void PressNormal::Gather(const OrganModel& model, const SurfacePoint& at, double radius,
                         OrganState* state) {
  const SurfaceMesh& rest = model.rest();
  state->neighbourhoods.Collect(rest.vertices, at,
                                {.vertices = KernelPatch::kMaxVertices, .reach = radius}, &around_);
  GatherKernel(rest, around_, at, at.Position(model.rest_normals(), rest.triangles), radius,
               &kernel_);
}

Vector3d PressNormal::Mean(const Points& normals) const {
  Vector3d sum = Vector3d::Zero();
  for (int i = 0; i < kernel_.vertex_count; ++i) {
    sum += kernel_.weights[i] * normals.row(kernel_.vertices[i]).transpose();
  }
  return sum.stableNormalized();
}

Vector3d PressNormal::Pressed(const OrganModel& model, const OrganState& state) const {
  Vector3d sum = Vector3d::Zero();
  for (int i = 0; i < kernel_.vertex_count; ++i) {
    sum += kernel_.weights[i] * VertexNormal(state.vertices, model.rest().triangles,
                                             model.topology(), kernel_.vertices[i]);
  }
  return sum.stableNormalized();
}

Matrix3d PressNormal::Compliance(const OrganModel& model, int tip, OrganState* state) {
  const Triangles& triangles = model.rest().triangles;
  moved_count_ = 0;
  moved_vertex_.fill(-1);
  Vector3d sum = Vector3d::Zero();
  Matrix3d sum_rate = Matrix3d::Zero();
  for (int i = 0; i < kernel_.vertex_count; ++i) {
    const int vertex = kernel_.vertices[i];
    Vector3d area = Vector3d::Zero();  // twice the ring's
    Matrix3d rate = Matrix3d::Zero();
    for (int t : model.topology().TrianglesAround(vertex)) {
      std::array<Vector3d, 3> p;
      std::array<Matrix3d, 3> moved;
      for (int k = 0; k < 3; ++k) {
        p[k] = state->vertices.row(triangles(t, k));
        moved[k] = MovedBy(tip, triangles(t, k), vertex, model, state);
      }
      const Vector3d a = p[1] - p[0], b = p[2] - p[0];
      area += a.cross(b);
      rate += CrossMatrix(a) * (moved[2] - moved[0]) - CrossMatrix(b) * (moved[1] - moved[0]);
    }
    const double size = area.norm();
    if (!(size > 0)) continue;
    const Vector3d n = area / size;
    sum += kernel_.weights[i] * n;
    sum_rate += kernel_.weights[i] / size * (rate - n * (n.transpose() * rate));
  }
  const double length = sum.norm();
  if (!(length > 0)) return Matrix3d::Zero();
  const Vector3d n = sum / length;
  return (sum_rate - n * (n.transpose() * sum_rate)) / length;
}

const Matrix3d& PressNormal::MovedBy(int tip, int vertex, int centre, const OrganModel& model,
                                     OrganState* state) {
  const auto slot_of = [&](int v) {
    int slot = static_cast<int>(static_cast<unsigned>(v) * 2654435761u >> 22);
    while (moved_vertex_[slot] >= 0 && moved_vertex_[slot] != v) slot = (slot + 1) % kSlots;
    return slot;
  };
  int slot = slot_of(vertex);
  if (moved_vertex_[slot] != vertex && moved_count_ >= kMaxMoved) {
    vertex = centre;
    slot = slot_of(centre);
  }
  if (moved_vertex_[slot] == vertex) return moved_[slot];
  ++moved_count_;
  moved_vertex_[slot] = vertex;
  moved_[slot] = state->tips.Coupling(VertexRow(model, vertex, state), tip);
  return moved_[slot];
}

}  // namespace hpdm
