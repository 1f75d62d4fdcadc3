#pragma once

#include <cstdint>
#include <span>

namespace hpdm {

/// Returns the TrueType file of the picture's font, DejaVu Sans. It is embedded in the program so
/// that it runs anywhere (package fonts-dejavu-core, whose licence permits this).
std::span<const std::uint8_t> FontFile();

}  // namespace hpdm
