#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "engine/base/angle.h"
#include "engine/base/error.h"
#include "scenes/loader/scene.h"
#include "scenes/loader/scene_edit.h"
#include "tests/support/read_file.h"

/// Helpers of the tests of scenes.
namespace hpdm {

inline testing::AssertionResult Contains(const std::string& text, const std::string& part) {
  if (text.find(part) != std::string::npos) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "no \"" << part << "\" in \"" << text << '"';
}

inline testing::AssertionResult StartsWith(const std::string& text, const std::string& part) {
  if (text.starts_with(part)) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "no \"" << part << "\" at the start of \"" << text << '"';
}

/// A folder with mesh and picture files that scenes can name; the loader only checks that they
/// exist.
class SceneFolder {
 public:
  SceneFolder() {
    std::string name = testing::TempDir() + "hpdm_scene_XXXXXX";
    path_ = mkdtemp(name.data());
    std::filesystem::create_directory(path_ / "meshes");
    for (const char* file : {"m.obj", "t.png", "meshes/liver_1332.obj"}) Write(file, "");
  }
  ~SceneFolder() { std::filesystem::remove_all(path_); }
  SceneFolder(const SceneFolder&) = delete;
  SceneFolder& operator=(const SceneFolder&) = delete;

  std::filesystem::path Write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name, std::ios::binary) << text;
    return path_ / name;
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

inline const std::string kOrgan = "[[organ]]\nname='liver'\nmesh='m.obj'\n";
inline const std::string kInstrument = "[[instrument]]\nname='probe'\ntrocar=[0,-0.1,0.2]\n";

template <typename Load>
std::string ErrorOf(const Load& load) {
  try {
    load();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

/// Loads scenes from texts in such a folder and shortens their errors.
class SceneTest : public testing::Test {
 protected:
  Scene Load(const std::string& text) const { return LoadScene(folder_.Write("s.toml", text)); }
  /// Reads the text as a scene in the folder, without writing a file.
  Scene Read(const std::string& text) const { return ParseScene(text, folder_.path() / "s.toml"); }
  /// The message without the folder: "s.toml:LINE:COLUMN: ...". Empty when the scene loads.
  std::string LoadError(const std::string& text) const {
    return Shorten(ErrorOf([&] { Load(text); }));
  }
  std::string ReadError(const std::string& text) const {
    return Shorten(ErrorOf([&] { Read(text); }));
  }
  std::string Shorten(std::string message) const {
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    const std::string prefix = folder_.path().string() + "/";
    for (std::size_t at = 0; (at = message.find(prefix)) != std::string::npos;) {
      message.erase(at, prefix.size());
    }
    return message;
  }

  SceneFolder folder_;
};

}  // namespace hpdm
