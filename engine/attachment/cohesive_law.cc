#include "engine/attachment/cohesive_law.h"

#include <algorithm>
#include <cmath>

namespace hpdm {

CohesiveLaw::CohesiveLaw(const AttachmentOptions& attachment)
    : stiffness(attachment.young / attachment.thickness),
      onset(attachment.strength / stiffness),
      final(2 * attachment.toughness / attachment.strength),
      toughness(attachment.toughness) {}

CohesiveLaw::CohesiveLaw(const AttachmentOptions& attachment, double length)
    : stiffness(attachment.young * attachment.thickness / (length * length)),
      onset(attachment.strength * length / attachment.young),
      final(2 * attachment.toughness / attachment.strength),
      toughness(attachment.toughness * attachment.thickness / length),
      leaf(true) {}

double CohesiveLaw::Effective(const Vector3d& delta, const Vector3d& normal) const {
  const double along = normal.dot(delta);
  if (leaf) return std::max(along, 0.0);
  return along >= 0 ? delta.norm() : (delta - along * normal).norm();
}

bool CohesiveLaw::Closed(const Vector3d& delta, const Vector3d& normal) const {
  const double along = normal.dot(delta);
  return along < 0 && (leaf || (delta - along * normal).norm() < final);
}

double CohesiveLaw::Damage(double effective) const {
  if (!(effective > onset)) return 0;
  return std::min(1.0, final * (effective - onset) / (effective * (final - onset)));
}

double CohesiveLaw::Dissipated(double damage) const {
  const double effective = onset * final / (final - damage * (final - onset));
  return toughness * (effective - onset) / (final - onset);
}

}  // namespace hpdm
