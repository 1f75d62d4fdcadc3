#pragma once

#include <cstdint>
#include <span>

namespace hpdm {

/// The font of the picture's text, DejaVu Sans (a TrueType file of the package fonts-dejavu-core,
/// whose licence permits it), which becomes part of the program so that it runs anywhere.
std::span<const std::uint8_t> FontFile();

}  // namespace hpdm
