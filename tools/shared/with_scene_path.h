#pragma once

#include "engine/base/error.h"
#include "scenes/loader/scene_place.h"

namespace hpdm {

/// Runs `build`, which does not know the scene's file. Puts the scene's path before the message of
/// an InputError that it throws, with the line and column of the key at fault if it names one.
template <typename Build>
decltype(auto) WithScenePath(const Scene& scene, const Build& build) {
  try {
    return build();
  } catch (const InputError& error) {
    throw InputError(PlaceInScene(scene, error.key()) + ": " + error.what());
  }
}

/// The same for a `build` whose messages name another file: only if they name a key of the scene.
template <typename Build>
decltype(auto) WithScenePlace(const Scene& scene, const Build& build) {
  try {
    return build();
  } catch (const InputError& error) {
    if (error.key().table.empty()) throw;
    throw InputError(PlaceInScene(scene, error.key()) + ": " + error.what());
  }
}

}  // namespace hpdm
