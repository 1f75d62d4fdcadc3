#pragma once

#include "engine/base/types.h"

namespace hpdm {

/// The layer of an attachment after a step (attachment_options.h).
struct AttachmentOutcome {
  Vector3d load_W = Vector3d::Zero();  ///< N: force of the layer on b.
  double largest_damage = 0;           ///< 0..1.
  double freed_area = 0;               ///< m^2, of samples with d = 1.
  double burnt_area = 0;               ///< m^2 of it, by burning.
  double cut_area = 0;                 ///< m^2 of it, by scissors. The rest is torn.
  double dissipated = 0;               ///< J, since the start.
};

}  // namespace hpdm
