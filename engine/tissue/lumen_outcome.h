#pragma once

namespace hpdm {

/// A filled lumen after a step (lumen_leaks.h).
struct LumenOutcome {
  double pressure = 0;      ///< Pa, of the fluid over the surroundings.
  double lost = 0;          ///< m^3: fluid that has left it, less gas that has entered.
  bool perforated = false;  ///< It leaks.
};

}  // namespace hpdm
