#pragma once

#include <limits>

namespace hpdm {

/// How much a deformation step does for one organ: what its state needs, within what the time
/// allows (strain_blend_controller.h). Logged, and applied by a replay.
struct StepQuality {
  /// Most of Newton's method; finite strain only.
  int newton_iterations = std::numeric_limits<int>::max();
  double finite_strain_blend = 1;  ///< 0..1, of finite strain in the energy (blended_energy.h); 0:
                                   ///< small strain, which takes no Newton iterations.
  double refinement_weight = 1;    ///< 0..1, of the local functions' part in the compliance.
};

}  // namespace hpdm
