#pragma once

#include <string>

#include "scenes/loader/scene.h"

namespace hpdm {

/// Returns the scene's text with one key set to `value`, a TOML value. `key` names tables by name or
/// number: "timing.haptic_hz", "organ.liver.material.young", "instrument[0].hand.depth". The
/// author's comments and order stay; a missing key is added to its table. Throws InputError.
std::string WithKey(const Scene& scene, const std::string& key, const std::string& value);

}  // namespace hpdm
