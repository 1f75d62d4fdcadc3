#pragma once

#include <cmath>
#include <vector>

namespace hpdm {

/// y = factor x^exponent, fitted by least squares of log y over log x.
struct PowerLaw {
  double exponent = 0;
  double factor = 0;
  double r_squared = 0;  ///< Coefficient of determination of the logarithms: 1 if all points lie on
                         ///< the line.
};

/// Fits the law. `x` and `y` have equal length, positive values and at least two different x.
inline PowerLaw FitPowerLaw(const std::vector<double>& x, const std::vector<double>& y) {
  double mean_x = 0, mean_y = 0;
  const double n = static_cast<double>(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    mean_x += std::log(x[i]) / n;
    mean_y += std::log(y[i]) / n;
  }
  double xx = 0, xy = 0, yy = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double dx = std::log(x[i]) - mean_x, dy = std::log(y[i]) - mean_y;
    xx += dx * dx;
    xy += dx * dy;
    yy += dy * dy;
  }
  const double exponent = xy / xx;
  return {exponent, std::exp(mean_y - exponent * mean_x), yy > 0 ? xy * xy / (xx * yy) : 1};
}

}  // namespace hpdm
