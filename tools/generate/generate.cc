#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "engine/mesh/surface_mesh.h"
#include "render/image/image_file.h"
#include "scenes/generator/mesh_assets.h"
#include "scenes/generator/meshing/obj_writer.h"
#include "scenes/generator/picture_assets.h"
#include "tools/command_line.h"
#include "tools/commands.h"
#include "tools/shared/staged_file.h"

namespace hpdm {
namespace {

struct GenerateOptions {
  std::vector<std::string> names;
  std::string out;
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

void WritePicture(const std::string& name, const std::filesystem::path& folder) {
  const Image picture = MakePictureAsset(name);
  const std::filesystem::path path = folder / name;
  WritePng(path, picture, PngEffort::kSmall);
  std::printf("%s: %d x %d pixels, %.0f kB\n", path.string().c_str(), picture.width, picture.height,
              static_cast<double>(std::filesystem::file_size(path)) / 1000);
}

void WriteMesh(const std::string& name, const std::filesystem::path& folder) {
  const SurfaceMesh mesh = MakeMeshAsset(name);
  const std::filesystem::path path = folder / (name + ".obj");
  WriteTextFile(path, MeshAssetObj(name, mesh));
  const Vector3d size = mesh.vertices.colwise().maxCoeff() - mesh.vertices.colwise().minCoeff();
  std::printf("%s: %d vertices, %d triangles, %.1f ml, %.1f x %.1f x %.1f mm\n",
              path.string().c_str(), static_cast<int>(mesh.vertices.rows()),
              static_cast<int>(mesh.triangles.rows()),
              EnclosedVolume(mesh.vertices, mesh.triangles) * 1e6, size.x() * 1e3, size.y() * 1e3,
              size.z() * 1e3);
}

void Generate(const GenerateOptions& options) {
  if (options.list) return ListAssets();
  if (options.out.empty()) {
    throw InputError("generate: no output folder; give --out DIR, or --list for the names");
  }
  std::vector<std::string> names = options.names;
  if (names.empty()) {
    names = options.pictures ? CommittedNames(PictureAssets()) : CommittedNames(MeshAssets());
  }
  MakeOutFolder(options.out);
  for (const std::string& name : names) {
    IsPicture(name) ? WritePicture(name, options.out) : WriteMesh(name, options.out);
  }
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
  command.AddFlag("--pictures", options->pictures, "Without names, make all of scenes/textures");
  command.AddFlag("--list", options->list, "List the assets and exit");
  command.OnRun([options] { Generate(*options); });
}

}  // namespace hpdm
