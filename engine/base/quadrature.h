#pragma once

#include "engine/base/types.h"

namespace hpdm {

/// Points and weights that integrate over tissue: the integral of f is about sum_q weights[q]
/// f(points[q]).
struct Quadrature {
  Points points;            ///< Q x 3, world, m.
  Eigen::VectorXd weights;  ///< Q, m^3, positive.
};

}  // namespace hpdm
