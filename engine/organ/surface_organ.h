#pragma once

#include <memory>
#include <optional>

#include "engine/baselines/mass_spring.h"
#include "engine/baselines/surface_continuum.h"
#include "engine/organ/organ_mechanics.h"

namespace hpdm {

/// Tissue that its surface alone stands for (models "continuum" and "mass_spring"): every vertex is
/// a control point (n = V).
class SurfaceOrgan final : public OrganMechanics {
 public:
  /// Throws InputError (organ's name, fault, remedy), for example for a surface without volume.
  explicit SurfaceOrgan(const OrganSurface& surface);

  /// The springs of model "mass_spring" at rest, to copy; nullptr for model "continuum".
  const MassSpring* springs() const { return springs_ ? &*springs_ : nullptr; }

  std::unique_ptr<Relaxation> MakeRelaxation(int slots,
                                             std::function<Nanoseconds()> clock) const override;
  void AddToRow(const SurfacePoint& at, double weight, const ActiveRefinement& active,
                Eigen::Ref<Eigen::RowVectorXd> row) const override;

 private:
  std::optional<SurfaceContinuum> continuum_;
  std::optional<MassSpring> springs_;
};

}  // namespace hpdm
