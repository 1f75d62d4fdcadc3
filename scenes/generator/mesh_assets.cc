#include "scenes/generator/mesh_assets.h"

#include <memory>

#include "engine/base/error.h"
#include "scenes/generator/meshing/obj_writer.h"
#include "scenes/generator/organ_mesh.h"
#include "scenes/generator/shapes/implicit_shapes.h"
#include "scenes/generator/shapes/instrument_mesh.h"

namespace hpdm {
namespace {

struct Recipe {
  MeshAsset asset;
  std::unique_ptr<ImplicitShape> (*shape)();
  OrganMeshOptions mesh;
};

/// An instrument's part as an asset.
struct PartRecipe {
  MeshAsset asset;
  InstrumentType type;
  int jaw;  ///< -1: the rigid part.
};

const std::vector<PartRecipe>& PartRecipes() {
  using enum InstrumentType;
  static const std::vector<PartRecipe> recipes = {
      {{"probe_562", "palpation probe, 562 triangles, in the tool frame", true}, kProbe, -1},
      {{"grasper", "grasper, shaft and fork, in the tool frame", true}, kGrasper, -1},
      {{"grasper_jaw_1", "grasper, jaw that opens towards +x", true}, kGrasper, 0},
      {{"grasper_jaw_2", "grasper, jaw that opens towards -x", true}, kGrasper, 1},
      {{"scissors", "scissors, shaft and fork, in the tool frame", true}, kScissors, -1},
      {{"scissors_blade_1", "scissors, blade that opens towards +x", true}, kScissors, 0},
      {{"scissors_blade_2", "scissors, blade that opens towards -x", true}, kScissors, 1},
      {{"hook", "hook electrode, in the tool frame", true}, kHook, -1},
  };
  return recipes;
}

const PartRecipe* FindPart(const std::string& name) {
  for (const PartRecipe& recipe : PartRecipes()) {
    if (recipe.asset.name == name) return &recipe;
  }
  return nullptr;
}

const std::vector<Recipe>& Recipes() {
  static const std::vector<Recipe> recipes = {
      {{"liver_274", "liver of 1.5 l, 274 triangles", true}, LiverShape, {274}},
      {{"liver_1332", "liver of 1.5 l, 1,332 triangles", true}, LiverShape, {1332}},
      {{"liver_5000", "liver of 1.5 l, 5,000 triangles", true}, LiverShape, {5000}},
      {{"liver_30000", "liver of 1.5 l, 30,000 triangles", false}, LiverShape, {30000}},
      {{"liver_120000", "liver of 1.5 l, 120,000 triangles", false}, LiverShape, {120000}},
      {{"stomach_2132", "stomach, solid, 2,132 triangles", true}, StomachShape, {2132}},
      {{"stomach_hollow", "stomach with a wall of 5 mm, 2,132 + 1,668 triangles", true},
       StomachShape,
       {2132, 1668, 5e-3}},
      {{"gallbladder", "gallbladder with a wall of 3 mm, 900 + 600 triangles", true},
       GallbladderShape,
       {900, 600, 3e-3}},
      {{"bent_organ", "solid bent like a J, limbs 10 mm apart, 1,600 triangles", true},
       BentOrganShape,
       {1600}},
  };
  return recipes;
}

const Recipe& FindRecipe(const std::string& name) {
  std::string names;
  for (const Recipe& recipe : Recipes()) {
    if (recipe.asset.name == name) return recipe;
    names += " " + recipe.asset.name;
  }
  for (const PartRecipe& recipe : PartRecipes()) names += " " + recipe.asset.name;
  throw InputError("mesh asset '" + name + "' is unknown; choose from:" + names);
}

}  // namespace

const std::vector<MeshAsset>& MeshAssets() {
  static const std::vector<MeshAsset> assets = [] {
    std::vector<MeshAsset> all;
    for (const Recipe& recipe : Recipes()) all.push_back(recipe.asset);
    for (const PartRecipe& recipe : PartRecipes()) all.push_back(recipe.asset);
    return all;
  }();
  return assets;
}

SurfaceMesh MakeMeshAsset(const std::string& name) {
  if (const PartRecipe* part = FindPart(name)) {
    const InstrumentMeshes model = MakeInstrument(part->type);
    return part->jaw < 0 ? model.rigid : model.jaws[static_cast<std::size_t>(part->jaw)];
  }
  const Recipe& recipe = FindRecipe(name);
  return MeshOrgan(*recipe.shape(), recipe.mesh);
}

std::string MeshAssetObj(const std::string& name, const SurfaceMesh& mesh) {
  const PartRecipe* part = FindPart(name);
  const std::string frame =
      part != nullptr
          ? "metres; origin at the centre of the tip's ball, z along the shaft to the trocar"
          : "metres; origin at the centre of volume, x to the patient's left, y to the head, "
            "z to the front";
  const MeshAsset& asset = part != nullptr ? part->asset : FindRecipe(name).asset;
  return ObjText(mesh, asset.description + "\n" + frame + "\nmade by: hpdm generate " + name);
}

}  // namespace hpdm
