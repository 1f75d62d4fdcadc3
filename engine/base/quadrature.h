#pragma once

#include "engine/base/types.h"

namespace hpdm {

/// Points and weights of a numerical integral over tissue:
///     int f dV ~ sum_q weights[q] f(points[q]).
struct Quadrature {
  Points points;            ///< Q x 3, world, m.
  Eigen::VectorXd weights;  ///< Q, m^3, positive.
};

}  // namespace hpdm
