#pragma once

#include <string>

#include "engine/base/error.h"
#include "scenes/loader/scene.h"

namespace hpdm {

/// Returns the place of a key in the scene's file, "FILE:LINE:COLUMN". If the table lacks the key,
/// it is the place of the table; if the scene lacks the table, it is the file alone. Set-up only.
std::string PlaceInScene(const Scene& scene, const OptionKey& key);

}  // namespace hpdm
