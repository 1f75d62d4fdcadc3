#include "scenes/generator/picture_assets.h"

#include <algorithm>

#include "engine/base/error.h"
#include "scenes/generator/mesh_assets.h"
#include "scenes/generator/texturing/abdomen_picture.h"
#include "scenes/generator/texturing/organ_colours.h"
#include "scenes/generator/texturing/texture_atlas.h"

namespace hpdm {
namespace {

constexpr const char* kAbdomen = "abdomen.png";
/// Pictures that are drawn large or often.
constexpr const char* kCommitted[] = {"liver_1332", "liver_5000", "stomach_2132", "stomach_hollow",
                                      "gallbladder"};

bool BeginsWith(const std::string& text, const char* start) { return text.rfind(start, 0) == 0; }

/// Returns null for names that are not organs.
SurfaceColour (*ColourOf(const std::string& mesh))() {
  if (BeginsWith(mesh, "liver")) return LiverColour;
  if (BeginsWith(mesh, "stomach")) return StomachColour;
  if (BeginsWith(mesh, "gallbladder")) return GallbladderColour;
  return nullptr;
}

}  // namespace

const std::vector<PictureAsset>& PictureAssets() {
  static const std::vector<PictureAsset> assets = [] {
    std::vector<PictureAsset> all;
    for (const MeshAsset& mesh : MeshAssets()) {
      if (ColourOf(mesh.name) == nullptr) continue;
      const bool committed = std::find(std::begin(kCommitted), std::end(kCommitted), mesh.name) !=
                             std::end(kCommitted);
      all.push_back({mesh.name + ".png", "texture of " + mesh.name, committed});
    }
    all.push_back({kAbdomen, "background: the abdomen around the organs", true});
    return all;
  }();
  return assets;
}

Image MakePictureAsset(const std::string& name) {
  if (name == kAbdomen) return AbdomenPicture(kAbdomenWidth, kAbdomenHeight);
  std::string names;
  for (const PictureAsset& asset : PictureAssets()) {
    if (asset.name == name) {
      const std::string mesh = name.substr(0, name.rfind('.'));
      return BakeTexture(MakeMeshAsset(mesh), kTextureSize, ColourOf(mesh)());
    }
    names += " " + asset.name;
  }
  throw InputError("picture asset '" + name + "' is unknown; choose from:" + names);
}

}  // namespace hpdm
