#pragma once

#include "engine/snapshots.h"

namespace hpdm {

/// The fibre nearest to a tip among those of the layers that an exercise asks to free.
struct NearestFibre {
  Vector3d p_W = Vector3d::Zero();  ///< Its nearest point, m.
  int attachment = -1;              ///< By its index in the scene.
  double gap = 0;                   ///< m, between the layer's two surfaces: the fibre's length.
};

}  // namespace hpdm
