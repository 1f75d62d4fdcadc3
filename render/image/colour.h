#pragma once

#include <Eigen/Core>
#include <cmath>

namespace hpdm {

/// A colour in sRGB, each component 0..1.
using Colour = Eigen::Vector3f;

/// Converts sRGB to linear light.
inline Eigen::Vector3f Linear(const Colour& srgb) {
  return srgb.unaryExpr(
      [](float c) { return c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f); });
}

}  // namespace hpdm
