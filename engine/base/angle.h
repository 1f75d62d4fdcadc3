#pragma once

#include <numbers>

namespace hpdm {

inline constexpr double kDegree = std::numbers::pi / 180;  ///< rad.

/// Converts an angle of a file. It may differ from `degrees` * kDegree in the last bit.
inline double Radians(double degrees) { return degrees * std::numbers::pi / 180; }

}  // namespace hpdm
