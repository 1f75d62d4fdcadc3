#pragma once

#include <string>
#include <vector>

#include "tools/python/native/python_session.h"
#include "tools/session/device_choice.h"

namespace hpdm {

/// The arguments that sessions and batches share, as Python gives them.

/// Returns the kind of the commands, "axes" or "tip". Throws ValueError on other texts.
CommandKind KindOf(const std::string& text);

/// Returns the devices that live in this program. `arguments`: "command", or those of --device.
/// Throws InputError if one of them does not exist or needs the real clock.
std::vector<DeviceChoice> DevicesOf(const std::vector<std::string>& arguments, const Scene& scene);

/// Returns what a picture shall hold. Throws ValueError on a size (pixels) that cannot be drawn.
PictureWish WishOf(int width, int height, bool depth, bool organs);

}  // namespace hpdm
