#include "render/tissue/burn_marks.h"

#include <algorithm>
#include <utility>

#include "engine/mesh/closest_point.h"

namespace hpdm {

BurnMarks::BurnMarks(std::vector<Triangles> triangles, const std::vector<int>& vertices)
    : triangles_(std::move(triangles)) {
  for (const int count : vertices) black_.emplace_back(ToSize(count), 0.0f);
}

bool BurnMarks::Follow(const SceneSnapshot& snapshot) {
  const double dt = std::clamp(ToSeconds(snapshot.step.time_ns - last_ns_), 0.0, kLongest);
  last_ns_ = snapshot.step.time_ns;
  bool grows = false;
  for (std::size_t t = 0; t < ToSize(snapshot.tool_count); ++t) {
    const SolvedContact& contact = snapshot.contacts[t];
    if (!snapshot.burns[t] || contact.kind != ContactKind::kPress) continue;
    if (contact.organ < 0 || ToSize(contact.organ) >= black_.size()) continue;
    const auto organ = ToSize(contact.organ);
    const Vector3d& p_tip_W = snapshot.tools[t].X_WT.translation();
    if (Burn(organ, snapshot.organs[organ], p_tip_W, dt)) grows = true;
  }
  return grows;
}

// Lets the mark under a tip grow. The corners of the triangle that it is in turn black by their weights
// too, so that a mark in the middle of a large triangle is seen.
bool BurnMarks::Burn(std::size_t organ, const OrganSnapshot& shape, const Vector3d& p_tip_W,
                     double dt) {
  const Vector3d p = p_tip_W - shape.offset_W;
  const auto vertex = [&shape](int v) -> Vector3d {
    return shape.vertices.row(v).transpose().cast<double>();
  };
  const Triangles& triangles = triangles_[organ];
  double least = kFarthest;
  Eigen::Index under = -1;
  TrianglePoint place;
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    const Vector3d a = vertex(triangles(f, 0));
    const Vector3d b = vertex(triangles(f, 1));
    const Vector3d c = vertex(triangles(f, 2));
    const Vector3d low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
    if (((low - p).array() > least).any() || ((p - high).array() > least).any()) continue;
    const TrianglePoint near = ClosestOnTriangle(p, a, b, c);
    const double distance = (near.point - p).norm();
    if (distance >= least) continue;
    least = distance;
    under = f;
    place = near;
  }
  if (under < 0) return false;
  std::vector<float>& black = black_[organ];
  bool grows = false;
  for (std::size_t v = 0; v < black.size(); ++v) {
    double share = 1 - (vertex(static_cast<int>(v)) - place.point).norm() / kReach;
    for (int corner = 0; corner < 3; ++corner) {
      if (triangles(under, corner) != static_cast<int>(v)) continue;
      share = std::max(share, place.barycentric[corner]);
    }
    const double added = dt / kTime * share;
    if (added <= 0 || black[v] >= 1) continue;
    black[v] = std::min(1.0f, black[v] + static_cast<float>(added));
    grows = true;
  }
  return grows;
}

}  // namespace hpdm
