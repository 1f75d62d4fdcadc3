#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>

#include "tools/replay/replay_view.h"
#include "tools/session/stop_signals.h"
#include "tools/session/trainer_window.h"

namespace hpdm {

/// Shows a replayed session in a window at the speed of its clock. The keys of the view work as in
/// a session (trainer_input.h): the scope, overlays, pause, screenshot; Esc ends the replay. The
/// instruments follow the log. The last step stays until Esc. Main thread.
class ReplayWindow : public PictureViewer {
 public:
  /// Opens the window. The signals and the session must outlive this. Throws MachineError as Window
  /// does, InputError for impossible options.
  ReplayWindow(const ReplayViewOptions& options, const StopSignals& signals, Session* session);
  ~ReplayWindow() override;
  ReplayWindow(const ReplayWindow&) = delete;
  ReplayWindow& operator=(const ReplayWindow&) = delete;

  /// Waits until the step is due, draws it and handles the input meanwhile. False if the user or a
  /// signal ended the replay, or the display is lost.
  bool OnStep(Nanoseconds time_ns) override;

  /// Shows the last step until the user ends it.
  void StayOpen();

  /// Number of screenshots, and their folder.
  std::uint64_t screenshots() const { return render_.screenshots_written(); }
  const std::filesystem::path& screenshot_folder() const { return screenshot_folder_; }

 private:
  using Clock = std::chrono::steady_clock;

  ReplayWindow(const LaparoscopeOptions& camera, const RenderOptions& options,
               const std::filesystem::path& screenshots, const StopSignals& signals,
               Session* session);
  /// Handles the input for at most `seconds`; false if the replay ends.
  bool Pump(double seconds);
  bool Paused();

  const StopSignals& signals_;
  std::filesystem::path screenshot_folder_;
  TripleBuffer<SessionControl> control_;  // the log has the session's controls; this one is ours
  TrainerWindow window_;
  std::optional<Clock::time_point> begin_;  // when session time 0 was, without pauses
};

}  // namespace hpdm
