#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "tools/replay/replay_view.h"
#include "tools/session/stop_signals.h"

namespace hpdm {

/// The folder of a film's frames, beside the film. It is removed with this.
class FilmFolder {
 public:
  /// Checks what would otherwise fail after the replay. Throws InputError if `film` does not end
  /// with ".mp4" or its folder cannot be written, MachineError without ffmpeg. Set-up.
  explicit FilmFolder(std::filesystem::path film);
  ~FilmFolder();
  FilmFolder(const FilmFolder&) = delete;
  FilmFolder& operator=(const FilmFolder&) = delete;

  const std::filesystem::path& film() const { return film_; }
  const std::filesystem::path& frames() const { return frames_; }

 private:
  std::filesystem::path film_, frames_;
};

/// Makes a film of a replayed session: a picture of each step, in session time.
///
///     OnStep -> NAME.mp4.part-XXXXXX/frame_000000.png ... -> Finish: ffmpeg -> NAME.mp4
///
/// The film appears only when it is complete. Main thread.
class ReplayFilm : public PictureViewer {
 public:
  /// `fps`: frames per second of session time. `end`: session time of the log's last step, for the
  /// progress. The folder, the signals and the session must outlive this. Throws MachineError
  /// without OpenGL, InputError for impossible options.
  ReplayFilm(const ReplayViewOptions& options, const FilmFolder& folder, double fps,
             Nanoseconds end, const StopSignals& signals, Session* session);

  /// Draws the step, and reports the progress on a terminal. False after a signal.
  bool OnStep(Nanoseconds time_ns) override;

  /// Makes the film; returns its number of frames. Throws MachineError if ffmpeg fails, InputError
  /// if the log has no step or the film cannot be written.
  std::uint64_t Finish();

 private:
  const FilmFolder& folder_;
  double fps_;
  Nanoseconds end_;
  const StopSignals& signals_;
  int percent_ = -1;  // reported last
};

}  // namespace hpdm
