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
///
/// A leaf of the thickness h that spans the length L has, per unit of its own area,
///     t = (1 - d) k delta_n n,   delta_n >= 0,      k = young h / L^2,
/// with n along its span. A slack one, delta_n < 0, carries nothing. What moves its edges across n only
/// stretches it in the second order, so it carries nothing either. The damage begins at
/// delta_0 = strength L / young and is full at delta_f = 2 toughness / strength.
struct CohesiveLaw {
  /// Makes the law of a layer.
  explicit CohesiveLaw(const AttachmentOptions& attachment);
  /// Makes the law of a leaf that spans `length` (m).
  CohesiveLaw(const AttachmentOptions& attachment, double length);

  /// Returns the effective displacement, m.
  double Effective(const Vector3d& delta, const Vector3d& normal) const;
  /// True if a layer carries pressure, or a leaf is slack.
  bool Closed(const Vector3d& delta, const Vector3d& normal) const;
  /// Returns the stiffness along all axes alike, Pa/m. The rest is BesideAlike().
  double Alike(double damage) const { return leaf ? 0 : (1 - damage) * stiffness; }
  /// True if a part of the stiffness acts along the normal alone.
  bool HasBeside(double damage, bool closed) const {
    return leaf ? !closed && damage < 1 : closed && damage > 0;
  }
  /// Returns the rest of the stiffness, along the normal, Pa/m: t = (Alike() 1 + BesideAlike() n n^T) delta.
  double BesideAlike(double damage, bool closed) const {
    if (!HasBeside(damage, closed)) return 0;
    return (leaf ? 1 - damage : damage) * stiffness;
  }
  /// Returns the damage after an effective displacement (m) that was never exceeded.
  double Damage(double effective) const;
  /// Returns the energy dissipated up to a damage, J/m^2; `toughness` at 1.
  double Dissipated(double damage) const;

  double stiffness = 0;  ///< k, Pa/m.
  double onset = 0;      ///< delta_0, m.
  double final = 0;      ///< delta_f, m.
  double toughness = 0;  ///< J/m^2.
  bool leaf = false;
};

}  // namespace hpdm
