#include "tools/report/metrics/session_files.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "engine/base/error.h"
#include "scenes/loader/scene_files.h"
#include "scenes/loader/scene_names.h"
#include "tools/session/session_path.h"
#include "tools/shared/base64.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxPictureBytes = 1'500'000;
constexpr std::size_t kMaxScreenshotBytes = 6'000'000;
constexpr std::size_t kMaxSummaryBytes = 10'000'000;
constexpr int kFramesShown = 4;

std::vector<std::uint8_t> Bytes(const fs::path& file, std::size_t most) {
  std::error_code error;
  if (file.empty() || fs::file_size(file, error) > most || error) return {};
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

std::string SceneName(const fs::path& folder) {
  const std::vector<std::uint8_t> text =
      Bytes(FileInside(folder, "summary.json"), kMaxSummaryBytes);
  const auto json = nlohmann::json::parse(text.begin(), text.end(), nullptr, false);
  if (!json.is_object() || !json.contains("scene") || !json["scene"].is_string()) return "";
  return json["scene"];
}

bool IsPng(std::span<const std::uint8_t> bytes) {
  constexpr std::uint8_t kSignature[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  return bytes.size() > sizeof kSignature &&
         std::equal(std::begin(kSignature), std::end(kSignature), bytes.begin());
}

/// Returns the PNG files of a folder inside the session's, in the order of their names.
std::vector<std::string> PngsIn(const fs::path& session, const std::string& folder) {
  std::vector<std::string> names;
  std::error_code error;
  if (!LiesInside(session, session / folder)) return names;
  for (fs::directory_iterator entry(session / folder, error), end; !error && entry != end;
       entry.increment(error)) {
    if (entry->path().extension() == ".png") {
      names.push_back(folder + "/" + entry->path().filename().string());
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

/// Returns names and captions of frames, evenly distributed in the order of their names.
std::vector<std::pair<std::string, std::string>> SomeFrames(const fs::path& folder) {
  const std::vector<std::string> names = PngsIn(folder, "frames");
  std::vector<std::pair<std::string, std::string>> some;
  const std::size_t count = names.size();
  for (int i = 0; i < kFramesShown && count > 0; ++i) {
    const std::size_t at = (2 * static_cast<std::size_t>(i) + 1) * count / (2 * kFramesShown);
    if (!some.empty() && some.back().first == names[at]) continue;
    some.emplace_back(names[at],
                      "Frame " + std::to_string(at + 1) + " of " + std::to_string(count));
  }
  return some;
}

/// Loads a picture if it is a PNG of at most `*left` bytes, which it uses up.
bool Load(const std::string& name, const std::string& caption, std::size_t* left,
          SessionFiles* files) {
  const std::vector<std::uint8_t> bytes = Bytes(FileInside(files->folder, name), *left);
  if (!IsPng(bytes)) return false;
  *left -= bytes.size();
  files->pictures.push_back({name, caption, "data:image/png;base64," + Base64Of(bytes)});
  return true;
}

}  // namespace

SessionFiles FindSessionFiles(const fs::path& path) {
  std::error_code error;
  SessionFiles files;
  if (fs::is_directory(path, error)) {
    files.folder = path;
    files.log = LogPathOf(path);
    files.scene = SceneName(path);
    for (const char* name : {"scene.toml", "summary.json"}) {
      if (FileInside(path, name).empty()) files.missing.emplace_back(name);
    }
  } else if (fs::is_regular_file(path, error)) {
    files.log = path;
  } else {
    throw InputError(path.string() + ": no such file; give a session's folder or its log");
  }
  const fs::path scene = FileInside(files.log.parent_path(), "scene.toml");
  files.instruments = SceneInstruments(scene);
  files.attachments = SceneAttachments(scene);
  files.exercise = SceneExercise(scene);
  return files;
}

SessionReading ReadSession(const SessionFiles& files, double force_limit, double depth_limit) {
  SessionReading reading =
      ReadSession(files.log.string(), force_limit, files.instruments, depth_limit, files.exercise);
  reading.report.scene = files.scene;
  std::vector<AttachmentReport>& attachments = reading.report.attachments;
  if (attachments.size() == files.attachments.size()) {
    for (std::size_t a = 0; a < attachments.size(); ++a) attachments[a].name = files.attachments[a];
  }
  return reading;
}

void LoadPictures(SessionFiles* files) {
  if (files->folder.empty()) return;
  std::size_t left = kMaxPictureBytes, left_for_screenshots = kMaxScreenshotBytes;
  Load("deepest.png", "At the deepest press", &left, files);
  const std::vector<std::string> screenshots = PngsIn(files->folder, "screenshots");
  for (std::size_t i = 0; i < screenshots.size(); ++i) {
    std::error_code error;
    const fs::path file = FileInside(files->folder, screenshots[i]);
    if (!file.empty() && fs::file_size(file, error) > left_for_screenshots && !error) {
      ++files->screenshots_left_out;
    } else {
      Load(screenshots[i], "Screenshot " + std::to_string(i + 1), &left_for_screenshots, files);
    }
  }
  Load("last.png", "At the end", &left, files);
  for (const auto& [name, caption] : SomeFrames(files->folder)) Load(name, caption, &left, files);
}

}  // namespace hpdm
