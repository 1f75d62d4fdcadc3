#pragma once

#include <string>

#include "render/image/colour.h"

namespace hpdm {

/// Returns the viridis colour of a value from 0 to 1 (clamped). Viridis (van der Walt, Smith 2015,
/// published under CC0) rises evenly in lightness and suits readers with red-green deficiency. This
/// map interpolates 17 of its 256 colours, within 0.023 of a component.
Colour MapColour(double value);

/// Returns the same map in GLSL: vec3 MapColour(float value).
std::string ColourMapGlsl();

}  // namespace hpdm
