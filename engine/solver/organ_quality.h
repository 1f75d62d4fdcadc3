#pragma once

#include <limits>

namespace hpdm {

/// How much a deformation step does for one organ: what its state needs, within what the time
/// allows (quality_choice.h). Logged, and obeyed by a replay.
struct OrganQuality {
  /// Most of Newton's method; finite strain only.
  int newton_iterations = std::numeric_limits<int>::max();
  double finite_share = 1;  ///< 0..1, of finite strain in the energy (blended_energy.h); 0: small
                            ///< strain, which takes no Newton iterations.
  double local_share = 1;   ///< 0..1, of the local functions' part in the compliance.
};

}  // namespace hpdm
