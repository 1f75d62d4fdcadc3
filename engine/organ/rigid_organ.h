#pragma once

#include <memory>

#include "engine/organ/organ_mechanics.h"

namespace hpdm {

/// An organ that does not deform (model "rigid"): no control points (n = 0). The hand feels a
/// virtual wall on its surface.
class RigidOrgan final : public OrganMechanics {
 public:
  /// Throws InputError (organ's name, fault, remedy) if the surface is not closed.
  explicit RigidOrgan(const OrganSurface& surface);

  std::unique_ptr<Relaxation> MakeRelaxation(int slots,
                                             std::function<Nanoseconds()> clock) const override;
  /// Adds nothing: a row has no columns.
  void AddToRow(const SurfacePoint& /*at*/, double /*weight*/, const ActiveRefinement& /*active*/,
                Eigen::Ref<Eigen::RowVectorXd> /*row*/) const override {}
};

}  // namespace hpdm
