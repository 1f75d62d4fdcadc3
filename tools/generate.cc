#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include "engine/error.h"
#include "engine/surface_mesh.h"
#include "scenes/mesh_assets.h"
#include "scenes/obj_writer.h"
#include "tools/commands.h"

namespace hpdm {
namespace {

struct GenerateOptions {
  std::vector<std::string> names;
  std::string out;
  bool list = false;
};

void ListAssets() {
  for (const MeshAsset& asset : MeshAssets()) {
    std::printf("%-15s %s%s\n", asset.name.c_str(), asset.description.c_str(),
                asset.committed ? "" : " (on demand)");
  }
}

void WriteAsset(const std::string& name, const std::filesystem::path& folder) {
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
    for (const MeshAsset& asset : MeshAssets()) {
      if (asset.committed) names.push_back(asset.name);
    }
  }
  std::error_code error;
  std::filesystem::create_directories(options.out, error);
  if (error) {
    throw InputError(options.out + ": cannot be created (" + error.message() +
                     "); choose another --out");
  }
  for (const std::string& name : names) WriteAsset(name, options.out);
}

}  // namespace

void AddGenerateCommand(CLI::App& app) {
  const auto options = std::make_shared<GenerateOptions>();
  CLI::App* command = app.add_subcommand("generate", "Make the project's meshes from their shapes");
  std::vector<std::string> known;
  for (const MeshAsset& asset : MeshAssets()) known.push_back(asset.name);
  command->add_option("names", options->names, "Assets to make; all of scenes/meshes by default")
      ->check(CLI::IsMember(known).description(""));  // before anything is written
  command->add_option("--out", options->out, "Folder to write NAME.obj to; made when missing");
  command->add_flag("--list", options->list, "List the assets and stop");
  command->callback([options] { Generate(*options); });
}

}  // namespace hpdm
