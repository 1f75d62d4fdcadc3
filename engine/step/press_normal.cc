#include "engine/step/press_normal.h"

#include "engine/step/tip_contact.h"

namespace hpdm {
namespace {

Matrix3d CrossMatrix(const Vector3d& a) {
  return (Matrix3d() << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0).finished();
}

// The displacements of vertices for a unit force on a tip, m/N: a hash table.
class MovedVertices {
 public:
  MovedVertices(int tip, const OrganModel& model, OrganState* state)
      : tip_(tip), model_(model), state_(*state) {
    vertex_.fill(kFree);
  }

  const Matrix3d& operator[](int vertex) {
    int slot = static_cast<int>(static_cast<unsigned>(vertex) * 2654435761u >> 23);
    while (vertex_[slot] != kFree && vertex_[slot] != vertex) slot = (slot + 1) % kSlots;
    if (vertex_[slot] == vertex) return moved_[slot];
    vertex_[slot] = vertex;
    moved_[slot] = state_.tips.Coupling(VertexRow(model_, vertex, &state_), tip_);
    return moved_[slot];
  }

 private:
  static constexpr int kSlots = 512, kFree = -1;

  int tip_;
  const OrganModel& model_;
  OrganState& state_;
  std::array<int, kSlots> vertex_;
  std::array<Matrix3d, kSlots> moved_;
};

}  // namespace

void PressNormal::Gather(const OrganModel& model, const SurfacePoint& at, double radius,
                         OrganState* state) {
  const SurfaceMesh& rest = model.rest();
  Neighbourhood around;
  KernelSamples kernel;
  state->neighbourhoods.Collect(rest.vertices, at, {.vertices = kMaxVertices, .reach = radius},
                                &around);
  GatherKernel(rest, around, at, at.Position(model.rest_normals(), rest.triangles), radius,
               &kernel);
  Take(kernel);
}

void PressNormal::Take(const KernelSamples& kernel) {
  // The samples of a triangle follow each other.
  count_ = 0;
  for (int i = 0; i < kernel.sample_count; ++i) {
    const SurfaceSample& sample = kernel.samples[i];
    if (count_ == 0 || shares_[count_ - 1].triangle != sample.triangle) {
      shares_[count_++] = {sample.triangle, 0};
    }
    shares_[count_ - 1].weight += sample.weight;
  }
}

// Returns zero if the normals cancel.
Vector3d PressNormal::Mean(const OrganModel& model, const Points& vertices) const {
  const Triangles& triangles = model.rest().triangles;
  Vector3d sum = Vector3d::Zero();
  for (int i = 0; i < count_; ++i) {
    const int t = shares_[i].triangle;
    const Vector3d p = vertices.row(triangles(t, 0));
    const Vector3d a = Vector3d(vertices.row(triangles(t, 1))) - p;
    const Vector3d b = Vector3d(vertices.row(triangles(t, 2))) - p;
    sum += shares_[i].weight * a.cross(b).stableNormalized();
  }
  return sum.stableNormalized();
}

Matrix3d PressNormal::Compliance(const OrganModel& model, int tip, OrganState* state) {
  const Triangles& triangles = model.rest().triangles;
  MovedVertices vertices(tip, model, state);
  Vector3d sum = Vector3d::Zero();
  Matrix3d sum_rate = Matrix3d::Zero();
  for (int i = 0; i < count_; ++i) {
    const int t = shares_[i].triangle;
    std::array<Vector3d, 3> p;
    std::array<Matrix3d, 3> moved;
    for (int k = 0; k < 3; ++k) {
      p[k] = state->vertices.row(triangles(t, k));
      moved[k] = vertices[triangles(t, k)];
    }
    const Vector3d a = p[1] - p[0], b = p[2] - p[0];
    const Vector3d area = a.cross(b);  // twice
    const double size = area.norm();
    if (!(size > 0)) continue;
    const Matrix3d rate =
        CrossMatrix(a) * (moved[2] - moved[0]) - CrossMatrix(b) * (moved[1] - moved[0]);
    const Vector3d n = area / size;
    sum += shares_[i].weight * n;
    sum_rate += shares_[i].weight / size * (rate - n * (n.transpose() * rate));
  }
  const double length = sum.norm();
  if (!(length > 0)) return Matrix3d::Zero();
  const Vector3d n = sum / length;
  return (sum_rate - n * (n.transpose() * sum_rate)) / length;
}

}  // namespace hpdm
