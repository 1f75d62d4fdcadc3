#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace hpdm {

/// A picture of width x height pixels: 3 bytes (R, G, B; sRGB) a pixel, rows from the top down,
/// without padding. Empty (0 x 0) until something is drawn.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;  ///< 3 width height bytes.

  /// The three bytes of the pixel in column x (from the left) and row y (from the top).
  const std::uint8_t* At(int x, int y) const {
    return rgb.data() + 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                             static_cast<std::size_t>(x));
  }
};

}  // namespace hpdm
