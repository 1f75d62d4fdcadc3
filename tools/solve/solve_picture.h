#pragma once

#include <string>

#include "tools/shared/static_case.h"

namespace hpdm {

/// Meaning of the colours in a solved shape's picture.
struct SolvedColours {
  bool error = false;     ///< True: distance from the reference; false: from rest.
  double full_scale = 0;  ///< m: value of the last colour; the first is 0.
};

/// Draws the case's displaced organ (V x 3, m) through the scene's laparoscope and writes a PNG of
/// 640 x 480 pixels. Each vertex is coloured by its distance from the reference (V x 3, m), if one
/// is given, otherwise from rest. The scale ends at the largest value, rounded up. Throws
/// InputError if the file cannot be written, MachineError if nothing can be drawn.
SolvedColours WriteSolvedPicture(const std::string& path, const StaticCase& load_case,
                                 const Points& displacements, const Points* reference);

}  // namespace hpdm
