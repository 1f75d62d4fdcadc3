#pragma once

#include <string>

#include "tools/shared/static_case.h"

namespace hpdm {

/// What the colours of a solved shape's picture mean.
struct SolvedColours {
  bool error = false;     ///< Distance from the reference; otherwise from rest.
  double full_scale = 0;  ///< m: the value with the last colour; the first is 0.
};

/// Draws the case's organ, displaced (V x 3, m), through the scene's laparoscope and writes the
/// picture as PNG of 640 x 480 pixels. Coloured by the distance of each vertex from the reference's
/// (V x 3, m) where one is given, else from rest; the scale ends at the largest value, rounded up.
/// Throws InputError when the file cannot be written, MachineError when nothing can be drawn.
SolvedColours WriteSolvedPicture(const std::string& path, const StaticCase& load_case,
                                 const Points& displacements, const Points* reference);

}  // namespace hpdm
