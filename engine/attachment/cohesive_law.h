#pragma once

#include "engine/attachment/attachment_options.h"
#include "engine/base/types.h"

namespace hpdm {

/// The bilinear law of a cohesive layer. With the displacement delta of one surface from the other,
/// and n the normal along which they part, the traction is
///     t = (1 - d) k delta,                      delta_n = n . delta >= 0
///     t = (1 - d) k delta + d k delta_n n,      delta_n < 0: the layer is closed
/// with k = young / thickness along the normal and across it. The damage d grows with the effective
/// displacement |delta| (of which delta_n counts only where it is positive) from 0 at
/// delta_0 = strength / k to 1 at delta_f = 2 toughness / strength, such that the traction falls
/// linearly. It never falls. A layer that has slid by more than delta_f carries no pressure: the
/// surfaces are no longer opposite each other.
struct CohesiveLaw {
  explicit CohesiveLaw(const AttachmentOptions& attachment);

  /// Returns the effective displacement, m.
  double Effective(const Vector3d& delta, const Vector3d& normal) const;
  /// True if the layer carries pressure.
  bool Closed(const Vector3d& delta, const Vector3d& normal) const;
  /// Returns the damage after an effective displacement (m) that was never exceeded.
  double Damage(double effective) const;
  /// Returns the energy dissipated up to a damage, J/m^2; `toughness` at 1.
  double Dissipated(double damage) const;

  double stiffness = 0;  ///< k, Pa/m.
  double onset = 0;      ///< delta_0, m.
  double final = 0;      ///< delta_f, m.
  double toughness = 0;  ///< J/m^2.
};

}  // namespace hpdm
