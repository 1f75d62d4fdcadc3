#include "scenes/loader/scene_files.h"

#include <algorithm>

#include "scenes/loader/file_hash.h"
#include "scenes/loader/scene_keys.h"
#include "scenes/loader/table_reader.h"

namespace hpdm {
namespace fs = std::filesystem;
namespace {

const SceneFile* Named(const std::vector<SceneFile>& files, const std::string& name) {
  const auto at = std::find_if(files.begin(), files.end(),
                               [&](const SceneFile& file) { return file.name == name; });
  return at == files.end() ? nullptr : &*at;
}

/// Returns the remedy for a name that leads to no file. It names the place unless that is the name.
std::string PathRule(const std::string& name, const fs::path& place) {
  if (fs::path(name).is_absolute()) return "check the path";
  const std::string rule = "paths are relative to the scene's folder";
  return place == name ? rule : rule + ", this one leads to \"" + place.string() + '"';
}

constexpr char kOrDropRecord[] = "or remove the [[file]] tables to use the present files";

}  // namespace

bool StaysInside(const fs::path& name) {
  const fs::path normal = name.lexically_normal();
  return !normal.empty() && !normal.is_absolute() && *normal.begin() != ".." && normal != ".";
}

bool LiesInside(const fs::path& folder, const fs::path& file) {
  std::error_code error;
  const fs::path whole_folder = fs::canonical(folder.empty() ? "." : folder, error);
  if (error) return false;
  const fs::path whole_file = fs::canonical(file, error);
  return !error && StaysInside(whole_file.lexically_relative(whole_folder));
}

void SceneFiles::ReadEntries(const TableReader& root) {
  for (const TableReader& table : root.Tables("file", kFileKeys)) {
    SceneFile entry;
    table.Require("name", "give the file's name as the scene writes it");
    table.ReadString("name", &entry.name);
    if (Named(entries_, entry.name) != nullptr) {
      table.Fail("name", "is already used", "give each file one table");
    }
    if (table.ReadString("copy", &entry.copy) && !StaysInside(entry.copy)) {
      table.Fail("copy", "leads out of the scene's folder", "name a file inside it");
    }
    table.Require("sha256", "give the file's SHA-256, as sha256sum prints it");
    table.ReadString("sha256", &entry.sha256);
    if (!IsSha256(entry.sha256)) {
      table.Fail("sha256", "is not a SHA-256", "give 64 lower-case hexadecimal digits");
    }
    entries_.push_back(std::move(entry));
  }
}

std::optional<SceneFiles::Fault> SceneFiles::Find(const std::string& name, std::string* path) {
  if (const SceneFile* known = Named(found_, name)) {
    *path = known->path;
    return std::nullopt;
  }
  SceneFile file;
  file.name = name;
  if (recorded()) {
    const SceneFile* entry = Named(entries_, name);
    if (entry == nullptr) {
      return Fault{"has no [[file]] table", std::string("add one, ") + kOrDropRecord};
    }
    file = *entry;
  }
  const fs::path place = (folder_ / (file.copy.empty() ? name : file.copy)).lexically_normal();
  std::error_code error;
  const fs::file_status status = fs::status(place, error);
  if (name.empty() || !fs::is_regular_file(status)) {
    return Fault{
        !name.empty() && fs::exists(status) ? "is not a regular file" : "there is no such file",
        PathRule(name, place)};
  }
  file.path = place.string();
  if (recorded()) {
    if (auto fault = Verify(file)) return fault;
  }
  *path = file.path;
  found_.push_back(std::move(file));
  return std::nullopt;
}

std::optional<SceneFiles::Fault> SceneFiles::Verify(const SceneFile& file) const {
  // The name alone must stay inside too: SessionFolder keeps copies by name in another folder.
  if (!StaysInside(file.copy.empty() ? file.name : file.copy) || !LiesInside(folder_, file.path)) {
    return Fault{
        "lies outside the folder of a recorded scene",
        std::string("copy it into the folder and set its [[file]] copy, ") + kOrDropRecord};
  }
  const std::string sha256 = Sha256OfFile(file.path);
  if (sha256 != file.sha256) {
    return Fault{"differs from the recorded file: its SHA-256 begins with " + sha256.substr(0, 8) +
                     ", the recorded one with " + file.sha256.substr(0, 8),
                 std::string("restore ") + file.path + ", " + kOrDropRecord};
  }
  return std::nullopt;
}

}  // namespace hpdm
