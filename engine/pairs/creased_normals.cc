#include "engine/pairs/creased_normals.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace hpdm {
namespace {

constexpr double kCreaseCosine = 0.5;

}  // namespace

CreasedNormals::CreasedNormals(const SurfaceMesh& rest, const SurfaceTopology& topology)
    : triangles_(&rest.triangles),
      vertices_(&rest.vertices),
      stamps_(ToSize(3 * rest.triangles.rows()), 0),
      normals_(ToSize(3 * rest.triangles.rows()), Vector3d::Zero()) {
  std::vector<Vector3d> faces(ToSize(rest.triangles.rows()));
  for (int t = 0; t < rest.triangles.rows(); ++t) {
    faces[t] = TwiceAreaNormal(rest.vertices, rest.triangles, t).normalized();
  }
  first_.push_back(0);
  for (int t = 0; t < rest.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      for (const int other : topology.TrianglesAround(rest.triangles(t, k))) {
        if (other == t || faces[t].dot(faces[other]) > kCreaseCosine) around_.push_back(other);
      }
      first_.push_back(static_cast<int>(around_.size()));
    }
  }
}

void CreasedNormals::Begin(const Points& vertices) {
  vertices_ = &vertices;
  if (++stamp_ == 0) {  // after 2^32 steps
    std::fill(stamps_.begin(), stamps_.end(), 0);
    stamp_ = 1;
  }
}

const Vector3d& CreasedNormals::AtCorner(int triangle, int k) {
  const std::size_t corner = ToSize(3 * triangle + k);
  if (stamps_[corner] != stamp_) {
    stamps_[corner] = stamp_;
    Vector3d sum = Vector3d::Zero();
    for (int i = first_[corner]; i < first_[corner + 1]; ++i) {
      sum += TwiceAreaNormal(*vertices_, *triangles_, around_[i]);
    }
    const double length = sum.norm();
    normals_[corner] = length > 0 ? Vector3d(sum / length) : Vector3d(Vector3d::Zero());
  }
  return normals_[corner];
}

Vector3d CreasedNormals::At(const SurfacePoint& at) {
  Vector3d sum = Vector3d::Zero();
  for (int k = 0; k < 3; ++k) sum += at.barycentric[k] * AtCorner(at.triangle, k);
  const double length = sum.norm();
  return length > 0 ? Vector3d(sum / length) : Vector3d(Vector3d::Zero());
}

bool IsBehind(const Vector3d& offset, const SurfacePoint& closest, const Points& vertices,
              const Triangles& triangles, const SurfaceTopology& topology) {
  std::array<int, 3> held;  // corners that hold the point
  int count = 0;
  for (int k = 0; k < 3; ++k) {
    if (closest.barycentric[k] > 0) held[count++] = triangles(closest.triangle, k);
  }
  const auto normal = [&](int t) {
    return Vector3d(TwiceAreaNormal(vertices, triangles, t).normalized());
  };
  if (count == 3) return offset.dot(normal(closest.triangle)) < 0;
  Vector3d sum = Vector3d::Zero();
  for (const int t : topology.TrianglesAround(held[0])) {
    int k = 0;
    while (triangles(t, k) != held[0]) ++k;
    const int next = triangles(t, (k + 1) % 3), last = triangles(t, (k + 2) % 3);
    if (count == 2) {
      if (next == held[1] || last == held[1]) sum += normal(t);
      continue;
    }
    const Vector3d p = vertices.row(held[0]);
    const Vector3d to_next = vertices.row(next).transpose() - p,
                   to_last = vertices.row(last).transpose() - p;
    sum += std::atan2(to_next.cross(to_last).norm(), to_next.dot(to_last)) * normal(t);
  }
  return offset.dot(sum) < 0;
}

}  // namespace hpdm
