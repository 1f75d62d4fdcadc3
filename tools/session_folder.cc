#include "tools/session_folder.h"

#include <fstream>

#include "engine/error.h"

namespace hpdm {

SessionFolder::SessionFolder(const std::filesystem::path& path, const Scene& scene) : path_(path) {
  std::error_code error;
  std::filesystem::create_directories(path_, error);
  if (error) {
    throw InputError(path_.string() + ": cannot make the session folder (" + error.message() +
                     "); choose another with --out");
  }
  if (std::filesystem::exists(File("session.lcmlog"))) {
    throw InputError(path_.string() +
                     ": already holds a session; choose another folder with --out");
  }
  std::ofstream copy(File("scene.toml"), std::ios::binary);
  copy << scene.source_text;
  copy.close();
  if (!copy) {
    throw InputError(File("scene.toml").string() +
                     ": cannot be written; choose a writable folder with --out");
  }
  const std::filesystem::path scene_folder = scene.path.parent_path();
  CopyFile(scene.background, scene_folder);
  for (const OrganOptions& organ : scene.organs) {
    for (const std::string& file : {organ.mesh, organ.texture}) CopyFile(file, scene_folder);
  }
  for (const InstrumentOptions& instrument : scene.instruments) {
    std::vector<std::string> files = {instrument.trace.file};
    for (int i = 0; i < instrument.HeldCount(); ++i) {
      const HeldInstrument& held = instrument.Held(i);
      files.push_back(held.mesh);
      files.insert(files.end(), held.jaws.meshes.begin(), held.jaws.meshes.end());
    }
    for (const std::string& file : files) {
      CopyFile(file, scene_folder);
    }
  }
}

// A file beside or above the scene's folder, or named absolutely, stays where it is: its name in
// the copied scene must not lead out of the session's folder.
void SessionFolder::CopyFile(const std::filesystem::path& file,
                             const std::filesystem::path& scene_folder) const {
  if (file.empty()) return;
  const std::filesystem::path name = file.lexically_relative(scene_folder);
  if (name.empty() || *name.begin() == "..") return;
  std::error_code error;
  std::filesystem::create_directories(File(name.parent_path().string()), error);
  if (!error) {
    std::filesystem::copy_file(file, File(name.string()),
                               std::filesystem::copy_options::skip_existing, error);
  }
  if (error) {
    throw InputError(File(name.string()).string() + ": cannot be written (" + error.message() +
                     "); choose a writable folder with --out");
  }
}

std::filesystem::path SessionFolder::FreeName() {
  int number = 1;
  const auto name = [&] {
    return std::filesystem::path("out") / ("session_" + std::to_string(number));
  };
  while (std::filesystem::exists(name())) ++number;
  return name();
}

}  // namespace hpdm
