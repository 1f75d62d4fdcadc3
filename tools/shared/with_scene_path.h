#pragma once

#include <string>

#include "engine/base/error.h"
#include "scenes/loader/scene.h"

namespace hpdm {

/// Runs `build`, which does not know the scene's file. Puts the scene's path before the message of
/// an InputError that it throws.
template <typename Build>
decltype(auto) WithScenePath(const Scene& scene, const Build& build) {
  try {
    return build();
  } catch (const InputError& error) {
    throw InputError(scene.path.string() + ": " + error.what());
  }
}

}  // namespace hpdm
