#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
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

/// The picture as the bytes of a PNG file (RGB, 8 bits). The fastest deflate level: a picture a
/// frame must fit in the frame's time, and the file grows by about a quarter only. `bytes` is
/// overwritten; a caller that keeps it saves its allocation. The same picture gives the same
/// bytes. An empty picture is a bug.
void EncodePng(const Image& image, std::vector<std::uint8_t>* bytes);

/// Writes the bytes to a file. False when that fails, with one line in `failure` that names the
/// file, the system's reason and the remedy; never throws.
bool WriteBytes(const std::filesystem::path& file, const std::vector<std::uint8_t>& bytes,
                std::string* failure);

/// EncodePng, then WriteBytes; throws its failure as InputError.
void WritePng(const std::filesystem::path& file, const Image& image);

/// Reads a PNG file; other colour types become RGB, 8 bits, on black. Throws InputError that names
/// the file when it is missing, is no PNG file, or measures more than 16,384 pixels on a side.
Image ReadPng(const std::filesystem::path& file);

}  // namespace hpdm
