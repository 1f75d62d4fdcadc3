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
