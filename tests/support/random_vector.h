#pragma once

#include "haptics/device/hand_script.h"

namespace hpdm {

/// A vector whose entries are uniform within +- size.
inline Vector3d RandomVector(HandRandom* random, double size = 1) {
  return {random->Uniform(-size, size), random->Uniform(-size, size), random->Uniform(-size, size)};
}

}  // namespace hpdm
