#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "render/image/image.h"

namespace hpdm {

/// Effort to compress. kFast: one filter and the fastest deflate level, for one picture a frame;
/// the file is about a quarter larger. kSmall: for pictures that are kept.
enum class PngEffort { kFast, kSmall };

/// Encodes the picture as a PNG file (RGB, 8 bits). Overwrites `bytes`; reuse it to save the
/// allocation. The same picture gives the same bytes. An empty picture is a bug.
void EncodePng(const Image& image, std::vector<std::uint8_t>* bytes,
               PngEffort effort = PngEffort::kFast);

/// Writes the bytes to a file. Returns false on failure, with one line in `failure`: the file, the
/// system's reason and the remedy. Never throws.
bool WriteBytes(const std::filesystem::path& file, const std::vector<std::uint8_t>& bytes,
                std::string* failure);

/// EncodePng, then WriteBytes; throws its failure as InputError.
void WritePng(const std::filesystem::path& file, const Image& image,
              PngEffort effort = PngEffort::kFast);

/// Reads a PNG file and converts it to RGB, 8 bits, on black. Throws InputError with the file's
/// name if it is missing, is not a PNG file, or has more than 16,384 pixels on a side.
Image ReadPng(const std::filesystem::path& file);

}  // namespace hpdm
