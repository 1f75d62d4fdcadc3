#pragma once

#include <string>

#include "render/image/colour.h"

namespace hpdm {

/// The colour of a value from 0 to 1 (clamped): viridis (van der Walt, Smith 2015, published under
/// CC0), whose lightness rises evenly and which readers who confuse red and green can read; between
/// 17 of its 256 colours it is linear, within 0.023 of a component.
Colour MapColour(double value);

/// The same in GLSL: vec3 MapColour(float value).
std::string ColourMapGlsl();

}  // namespace hpdm
