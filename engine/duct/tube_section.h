#pragma once

#include <cmath>
#include <numbers>

#include "engine/base/types.h"

namespace hpdm {

/// Stiffness of a tube's cross-section with the outer radius R and the inner radius r.
struct TubeSection {
  /// `young`: Pa; `radius`: outer, m; `wall` (m): less than the radius.
  TubeSection(double young, double radius, double wall, double poisson) {
    const double inner = radius - wall;
    const double area = std::numbers::pi * (radius * radius - inner * inner);
    const double second = std::numbers::pi * (std::pow(radius, 4) - std::pow(inner, 4)) / 4;
    const double shear = young / (2 * (1 + poisson));
    // Shear coefficient of a hollow circle, Cowper 1966 (doi:10.1115/1.3625046).
    const double m2 = inner * inner / (radius * radius), sum2 = (1 + m2) * (1 + m2);
    const double share =
        6 * (1 + poisson) * sum2 / ((7 + 6 * poisson) * sum2 + (20 + 12 * poisson) * m2);
    axial = young * area;
    across = share * shear * area;
    bending = young * second;
    torsion = shear * 2 * second;
  }

  double axial = 0;    ///< EA, N.
  double across = 0;   ///< kappa GA, N: shear.
  double bending = 0;  ///< EI = E pi (R^4 - r^4) / 4, N m^2.
  double torsion = 0;  ///< GJ, N m^2.
};

}  // namespace hpdm
