#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace hpdm {

class Session;
struct RenderOptions;

/// Size of a picture, px.
struct PictureSize {
  int width = 0, height = 0;
};

/// Reads the value of --size, "WIDTHxHEIGHT". Throws InputError if it is not one or a side is not
/// between Laparoscope::kMinSide and kMaxSide.
PictureSize ParsePictureSize(const std::string& text);

/// Returns the words of --overlay.
const std::vector<std::string>& OverlayNames();

/// Returns Overlay bits, or-ed, of words of OverlayNames().
std::uint32_t OverlaysOf(const std::vector<std::string>& names);

/// Returns how a session is drawn: at the size of a value of --size, with the overlays of words of
/// OverlayNames(). Throws InputError as ParsePictureSize() does.
RenderOptions RenderOptionsOf(const std::string& size, const std::vector<std::string>& overlays,
                              const Session& session);

}  // namespace hpdm
