#pragma once

#include <string>
#include <vector>

#include "render/image/image.h"

namespace hpdm {

/// A picture that the project can make from nothing, as `hpdm generate` lists it.
struct PictureAsset {
  std::string name;         ///< The file's: NAME.png, with the ending.
  std::string description;  ///< One line.
  bool committed;           ///< Kept in scenes/textures; the others are made on demand.
};

/// All pictures, in the order of the listing: a texture for every organ among the meshes
/// (mesh_assets.h), of the same name, and the abdomen that surrounds them.
const std::vector<PictureAsset>& PictureAssets();

/// Makes a picture, pixel for pixel the same on every run and x86-64 machine. Throws InputError for
/// an unknown name.
Image MakePictureAsset(const std::string& name);

}  // namespace hpdm
