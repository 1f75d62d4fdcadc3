#include "haptics/contact/reaction_force.h"

#include <algorithm>

namespace hpdm {
namespace {

constexpr double kMinLength = 0.01;  // of the rest length

int NeighbourCount(const ReactionNode& node) {
  return std::clamp(node.neighbour_count, 0, ReactionNode::kMaxNeighbours);
}

}  // namespace

Vector3d ForceOnTissue(const ReactionNode& node, const Vector3d& delta_W) noexcept {
  Vector3d force = node.k1 * delta_W;
  for (int i = 0; i < NeighbourCount(node); ++i) {
    const auto& [edge, d, k2] = node.neighbours[i];
    const Vector3d l = edge + delta_W;
    const double length = std::max(l.norm(), kMinLength * d);
    // Both zero: a spring without rest length whose ends meet has no force.
    if (!(length > 0)) continue;
    // Computes |l| - d from the change of length, |l|^2 - |edge|^2 = (2 edge + delta) . delta. The
    // difference itself would lose it to round-off if the edge is much longer than delta.
    const double at_start = edge.norm();
    const double change =
        length > kMinLength * d
            ? (2 * edge + delta_W).dot(delta_W) / (length + at_start) + (at_start - d)
            : length - d;
    force += k2 * change / length * l;
  }
  return force;
}

Matrix3d TissueStiffness(const ReactionNode& node, const Vector3d& delta_W) noexcept {
  Matrix3d K = node.k1 * Matrix3d::Identity();
  for (int i = 0; i < NeighbourCount(node); ++i) {
    const auto& [edge, d, k2] = node.neighbours[i];
    const Vector3d l = edge + delta_W;
    const double length = l.norm();
    if (length > kMinLength * d) {
      const Vector3d u = l / length;
      K += k2 * (Matrix3d::Identity() - d / length * (Matrix3d::Identity() - u * u.transpose()));
    } else {
      K += k2 * (d > 0 ? 1 - 1 / kMinLength : 1) * Matrix3d::Identity();
    }
  }
  return K;
}

}  // namespace hpdm
