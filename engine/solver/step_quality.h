#pragma once

#include <limits>

namespace hpdm {

/// The quality of a deformation step for one organ: what its state needs, within the time available
/// (strain_blend_controller.h). Logged, and applied by a replay.
struct StepQuality {
  /// Most iterations of Newton's method; finite strain only.
  int newton_iterations = std::numeric_limits<int>::max();
  /// Share (0..1) of finite strain in the energy (blended_energy.h). 0 is small strain, which needs
  /// no Newton iterations.
  double finite_strain_blend = 1;
  /// Weight (0..1) of the local functions in use.
  double refinement_weight = 1;
};

}  // namespace hpdm
