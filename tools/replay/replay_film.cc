#include "tools/replay/replay_film.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <system_error>
#include <utility>

#include "engine/base/error.h"
#include "tools/run/film.h"
#include "tools/session/picture_options.h"
#include "tools/shared/child_process.h"
#include "tools/shared/staged_file.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;

RenderOptions WithFrames(RenderOptions options, const fs::path& folder, double fps) {
  options.frame_folder = folder;
  options.frame_fps = fps;
  return options;
}

}  // namespace

FilmFolder::FilmFolder(fs::path film) : film_(std::move(film)) {
  if (film_.extension() != ".mp4") {
    throw InputError("--film " + film_.string() +
                     ": is not the name of an MP4 film; give a name that ends with .mp4");
  }
  try {
    RunChild({"ffmpeg", "-version"});
  } catch (const MachineError& error) {
    throw MachineError(std::string("--film: ") + error.what() + "; install the package ffmpeg");
  }
  std::string name = film_.string() + ".part-XXXXXX";
  if (mkdtemp(name.data()) == nullptr) {
    throw InputError(film_.string() + WriteFault(errno) + "choose another file with --film");
  }
  frames_ = name;
}

FilmFolder::~FilmFolder() {
  std::error_code ignored;
  fs::remove_all(frames_, ignored);
}

ReplayFilm::ReplayFilm(const ReplayViewOptions& options, const FilmFolder& folder, double fps,
                       Nanoseconds end, const StopSignals& signals, Session* session)
    : PictureViewer(ParseView(options.view, *session),
                    WithFrames(RenderOptionsOf(options.size, options.overlays, *session),
                               folder.frames(), fps),
                    nullptr, HeadlessContext, session),
      folder_(folder),
      fps_(fps),
      end_(end),
      signals_(signals) {
  render_.StartOnThisThread();
}

bool ReplayFilm::OnStep(Nanoseconds time_ns) {
  Draw();
  const int percent = end_ > 0 ? static_cast<int>(100 * time_ns / end_) : 100;
  if (percent != percent_ && isatty(STDERR_FILENO) != 0) {
    percent_ = percent;
    std::fprintf(stderr, "\rfilm: %.1f s of %.1f s%s", ToSeconds(time_ns), ToSeconds(end_),
                 percent == 100 ? "\n" : "");
  }
  const bool stop = signals_.WaitFor(0);
  if (stop && percent_ >= 0 && percent_ < 100) std::fputc('\n', stderr);
  return !stop;
}

std::uint64_t ReplayFilm::Finish() {
  const std::uint64_t frames = render_.frames_written();
  if (frames == 0) throw InputError(folder_.film().string() + ": not made: the log has no step");
  const fs::path made = folder_.frames() / "film.mp4";
  const std::string failure = MakeFilm(folder_.frames(), fps_, made);
  if (!failure.empty()) {
    // The frames are removed, so the message names the film alone.
    throw MachineError(folder_.film().string() + ": " + failure.substr(0, failure.find(';')) +
                       "; free space, or choose another --size");
  }
  std::error_code error;
  fs::rename(made, folder_.film(), error);
  if (error) {
    throw InputError(folder_.film().string() + WriteFault(error.value()) +
                     "choose another file with --film");
  }
  return frames;
}

}  // namespace hpdm
