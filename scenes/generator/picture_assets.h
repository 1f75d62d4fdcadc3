#pragma once

#include <string>
#include <vector>

#include "render/image/image.h"

namespace hpdm {

/// A generated picture, as `hpdm generate` lists it.
struct PictureAsset {
  std::string name;         ///< The file's name, NAME.png.
  std::string description;  ///< One line.
  bool committed;           ///< Kept in scenes/textures; the others are made on demand.
};

/// Returns all pictures, in the order of the listing: a texture of the same name for every organ
/// among the meshes (mesh_assets.h), and the surrounding abdomen.
const std::vector<PictureAsset>& PictureAssets();

/// Generates a picture, with the same pixels on every run and x86-64 machine. Throws InputError for
/// an unknown name.
Image MakePictureAsset(const std::string& name);

}  // namespace hpdm
