#include "tools/replay/replay_window.h"

#include <algorithm>
#include <string>
#include <system_error>
#include <utility>

#include "tools/session/picture_options.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;

/// Period of the pictures while no step is due.
constexpr std::chrono::milliseconds kStillPeriod(30);
constexpr double kStillSeconds = std::chrono::duration<double>(kStillPeriod).count();

ViewSettings SettingsOf(const LaparoscopeOptions& camera, const RenderOptions& options) {
  ViewSettings view;
  view.scope = camera;
  view.overlays = kOverlayText | options.overlays;
  return view;
}

/// Returns the first name replay_screenshots, replay_screenshots_2, ... that does not exist.
fs::path FreeFolder() {
  const std::string name = "replay_screenshots";
  std::error_code ignored;
  fs::path folder = name;
  for (int i = 2; fs::exists(folder, ignored); ++i) folder = name + "_" + std::to_string(i);
  return folder;
}

RenderOptions WithScreenshots(RenderOptions options, const fs::path& folder) {
  options.screenshot_folder = folder;
  return options;
}

}  // namespace

ReplayWindow::ReplayWindow(const ReplayViewOptions& options, const StopSignals& signals,
                           Session* session)
    : ReplayWindow(ParseView(options.view, *session),
                   RenderOptionsOf(options.size, options.overlays, *session), FreeFolder(), signals,
                   session) {}

ReplayWindow::ReplayWindow(const LaparoscopeOptions& camera, const RenderOptions& options,
                           const fs::path& screenshots, const StopSignals& signals,
                           Session* session)
    : PictureViewer(
          camera, WithScreenshots(options, screenshots), &session->view_settings,
          [this] { return window_.MakeContext(); }, session),
      signals_(signals),
      screenshot_folder_(screenshots),
      window_(options.width, options.height, "HPDM replay: " + session->scene().name,
              SettingsOf(camera, options), session->TrainerInstruments(),
              {session->view_settings, control_, {}}) {}

ReplayWindow::~ReplayWindow() { render_.EndOnThisThread(); }

bool ReplayWindow::OnStep(Nanoseconds time_ns) {
  const auto at = std::chrono::duration_cast<Clock::duration>(std::chrono::nanoseconds(time_ns));
  if (!begin_) begin_ = Clock::now() - at;
  while (true) {
    const double wait = std::chrono::duration<double>(*begin_ + at - Clock::now()).count();
    if (wait <= 0) break;
    if (!Pump(std::min(wait, kStillSeconds))) return false;
    if (!Paused()) continue;
    DrawAgain();
    begin_ = Clock::now() - at + kStillPeriod;
  }
  if (!Pump(0)) return false;
  Draw();
  return true;
}

void ReplayWindow::StayOpen() {
  while (Pump(kStillSeconds)) DrawAgain();
}

bool ReplayWindow::Pump(double seconds) {
  window_.Pump(seconds);
  return !window_.ended() && !window_.lost() && !signals_.WaitFor(0);
}

bool ReplayWindow::Paused() {
  control_.Update();
  return control_.Front().paused;
}

}  // namespace hpdm
