#include "haptics/device/hand.h"

#include <cmath>

#include "engine/base/error.h"

namespace hpdm {

Hand::Hand(double stiffness, double damping) : stiffness_(stiffness), damping_(damping) {
  if (!(std::isfinite(stiffness) && stiffness >= 0 && std::isfinite(damping) && damping >= 0)) {
    throw InputError(
        "instrument.hand: stiffness or damping: negative or not finite; give N/m and N s/m");
  }
}

}  // namespace hpdm
