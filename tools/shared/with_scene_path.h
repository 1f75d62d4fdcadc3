#pragma once

#include <string>

#include "engine/base/error.h"
#include "scenes/loader/scene.h"

namespace hpdm {

/// Runs `build`, which knows a part of the scene but not the file that it came from: the scene's
/// path is put before what it throws as InputError.
template <typename Build>
decltype(auto) WithScenePath(const Scene& scene, const Build& build) {
  try {
    return build();
  } catch (const InputError& error) {
    throw InputError(scene.path.string() + ": " + error.what());
  }
}

}  // namespace hpdm
