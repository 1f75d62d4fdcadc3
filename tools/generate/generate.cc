#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/quoted_token.h"
#include "engine/mesh/surface_mesh.h"
#include "render/image/image_file.h"
#include "scenes/generator/anatomy/anatomy.h"
#include "scenes/generator/anatomy/anatomy_scene.h"
#include "scenes/generator/mesh_assets.h"
#include "scenes/generator/meshing/obj_writer.h"
#include "scenes/generator/picture_assets.h"
#include "scenes/generator/texturing/texture_atlas.h"
#include "scenes/generator/texturing/texture_baking.h"
#include "tools/command_line.h"
#include "tools/commands.h"
#include "tools/shared/staged_file.h"

namespace hpdm {
namespace {

struct GenerateOptions {
  std::vector<std::string> names;
  std::string out;
  std::string anatomy;
  int seed = 0;
  bool pictures = false;
  bool list = false;
};

template <typename Asset>
void PrintAsset(const Asset& asset) {
  std::printf("%-18s %s%s\n", asset.name.c_str(), asset.description.c_str(),
              asset.committed ? "" : " (on demand)");
}

template <typename Asset>
std::vector<std::string> CommittedNames(const std::vector<Asset>& assets) {
  std::vector<std::string> names;
  for (const Asset& asset : assets) {
    if (asset.committed) names.push_back(asset.name);
  }
  return names;
}

bool IsPicture(const std::string& name) {
  return std::filesystem::path(name).extension() == ".png";
}

void ListAssets() {
  for (const MeshAsset& asset : MeshAssets()) PrintAsset(asset);
  for (const PictureAsset& asset : PictureAssets()) PrintAsset(asset);
}

void WritePicture(const std::string& name, const Image& picture,
                  const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / name;
  WritePng(path, picture, PngEffort::kSmall);
  std::printf("%s: %d x %d pixels, %.0f kB\n", path.string().c_str(), picture.width, picture.height,
              static_cast<double>(std::filesystem::file_size(path)) / 1000);
}

void WriteMesh(const std::string& name, const SurfaceMesh& mesh, const std::string& text,
               const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / (name + ".obj");
  WriteTextFile(path, text);
  const Vector3d size = mesh.vertices.colwise().maxCoeff() - mesh.vertices.colwise().minCoeff();
  std::printf("%s: %d vertices, %d triangles, %.1f ml, %.1f x %.1f x %.1f mm\n",
              path.string().c_str(), static_cast<int>(mesh.vertices.rows()),
              static_cast<int>(mesh.triangles.rows()),
              EnclosedVolume(mesh.vertices, mesh.triangles) * 1e6, size.x() * 1e3, size.y() * 1e3,
              size.z() * 1e3);
}

void WriteAsset(const std::string& name, const std::filesystem::path& folder) {
  if (IsPicture(name)) return WritePicture(name, MakePictureAsset(name), folder);
  const SurfaceMesh mesh = MakeMeshAsset(name);
  WriteMesh(name, mesh, MeshAssetObj(name, mesh), folder);
}

void WriteOrgan(const Anatomy::Organ& organ, const std::string& command,
                const std::filesystem::path& folder) {
  const std::string stem = FileStem(organ.name);
  const SurfaceMesh mesh = MeshOrgan(*organ.shape, organ.mesh);
  WriteMesh(stem, mesh, ObjText(mesh, organ.name + "\nmetres\nmade by: " + command), folder);
  WritePicture(stem + ".png", BakeTexture(mesh, kTextureSize, organ.colour()), folder);
}

AnatomyVariant VariantOf(const std::string& name) {
  for (const auto& [known, variant] : kAnatomyVariants) {
    if (known == name) return variant;
  }
  throw InputError("generate: unknown anatomy " + Quoted(name));
}

/// Writes the scene of an anatomy with all its files.
void WriteAnatomy(const GenerateOptions& options) {
  const std::filesystem::path folder = options.out;
  const std::string command =
      "hpdm generate --anatomy " + options.anatomy + " --seed " + std::to_string(options.seed);
  const Anatomy anatomy(VariantOf(options.anatomy), static_cast<std::uint64_t>(options.seed));
  WriteOrgan(anatomy.gallbladder, command, folder);
  for (const Anatomy::Organ& organ : anatomy.fixed) WriteOrgan(organ, command, folder);
  for (const char* name : {"liver_5000", "liver_5000.png", "abdomen.png"}) WriteAsset(name, folder);
  const std::filesystem::path scene = folder / "anatomy.toml";
  WriteTextFile(scene, AnatomySceneText(anatomy, command));
  std::printf("%s\n", scene.string().c_str());
}

void Generate(const GenerateOptions& options) {
  if (options.list) return ListAssets();
  if (options.out.empty()) {
    throw InputError("generate: no output folder; give --out DIR, or --list for the names");
  }
  if (!options.anatomy.empty()) {
    MakeOutFolder(options.out);
    return WriteAnatomy(options);
  }
  std::vector<std::string> names = options.names;
  if (names.empty()) {
    names = options.pictures ? CommittedNames(PictureAssets()) : CommittedNames(MeshAssets());
  }
  MakeOutFolder(options.out);
  for (const std::string& name : names) WriteAsset(name, options.out);
}

}  // namespace

void AddGenerateCommand(Command app) {
  const auto options = std::make_shared<GenerateOptions>();
  Command command = app.AddCommand("generate", "Generate the project's meshes and pictures");
  std::vector<std::string> known;
  for (const MeshAsset& asset : MeshAssets()) known.push_back(asset.name);
  for (const PictureAsset& asset : PictureAssets()) known.push_back(asset.name);
  command.AddOption("names", options->names, "Assets to make; default: all of scenes/meshes")
      .OneOfUnlisted(known);  // checked before anything is written
  command.AddOption("--out", options->out,
                    "Folder to write NAME.obj and NAME.png to; created if missing");
  std::vector<std::string> variants;
  for (const auto& [name, variant] : kAnatomyVariants) variants.emplace_back(name);
  const Option anatomy =
      command
          .AddOption("--anatomy", options->anatomy,
                     "Make a gallbladder with its ducts and vessels, as a scene with all its files")
          .OneOf(variants)
          .Excludes("names");
  command.AddOption("--seed", options->seed, "Another patient; 0: the mean sizes")
      .From(0, 1000000)
      .ShowDefault()
      .Needs(anatomy);
  command.AddFlag("--pictures", options->pictures, "Without names, make all of scenes/textures");
  command.AddFlag("--list", options->list, "List the assets and exit");
  command.OnRun([options] { Generate(*options); });
}

}  // namespace hpdm
