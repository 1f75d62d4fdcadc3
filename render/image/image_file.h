#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "render/image/image.h"

namespace hpdm {

/// How hard to look for a small file. kFast: one filter and the fastest deflate level, because a
/// picture a frame must fit in the frame's time; the file grows by about a quarter. kSmall: what is
/// kept for good.
enum class PngEffort { kFast, kSmall };

/// The picture as the bytes of a PNG file (RGB, 8 bits). `bytes` is overwritten; a caller that
/// keeps it saves its allocation. The same picture gives the same bytes. An empty picture is a bug.
void EncodePng(const Image& image, std::vector<std::uint8_t>* bytes,
               PngEffort effort = PngEffort::kFast);

/// Writes the bytes to a file. False when that fails, with one line in `failure` that names the
/// file, the system's reason and the remedy; never throws.
bool WriteBytes(const std::filesystem::path& file, const std::vector<std::uint8_t>& bytes,
                std::string* failure);

/// EncodePng, then WriteBytes; throws its failure as InputError.
void WritePng(const std::filesystem::path& file, const Image& image,
              PngEffort effort = PngEffort::kFast);

/// Reads a PNG file; other colour types become RGB, 8 bits, on black. Throws InputError that names
/// the file when it is missing, is no PNG file, or measures more than 16,384 pixels on a side.
Image ReadPng(const std::filesystem::path& file);

}  // namespace hpdm
