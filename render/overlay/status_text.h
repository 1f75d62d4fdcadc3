#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "engine/snapshots.h"
#include "render/overlay/view_settings.h"

namespace hpdm {

/// Names in the text, by index.
struct StatusNames {
  std::vector<std::string> organs;
  std::vector<std::vector<std::string>> instruments;  ///< [tool][ToolPose::instrument_index].
};

/// Inputs of the text at one frame.
struct Status {
  const ViewSettings& view;
  const SessionHealth& health;  ///< Default-constructed before the first.
  const SceneSnapshot& scene;
  double frame_hz = 0;     ///< Pictures per second; 0: unknown.
  double error_scale = 0;  ///< OrganVisual::error_scale; 0: without a reference.
};

enum class Tone { kPlain, kDim, kGood, kWarning, kAlarm };

struct StatusLine {
  std::string text;
  Tone tone = Tone::kPlain;
  std::optional<double> bar = {};  ///< A bar beside the text, 0 empty .. 1 full.
  std::string key = {};            ///< In the banner: a column before the text.
};

/// The text by its place: the corners outside the circular picture, and the middle over it.
struct StatusText {
  std::vector<StatusLine> loops;                               ///< Top left: rates and losses.
  std::vector<StatusLine> state;                               ///< Top right: recording, hints.
  std::array<std::vector<StatusLine>, kMaxInstruments> tools;  ///< Bottom left and right.
  std::vector<StatusLine> banner;                              ///< Middle: PAUSED, or the keys.
};

/// Force that fills the bar, N; careful handling of soft organs needs 1 to 3 N.
inline constexpr double kBarForce = 5;

/// Returns the picture's text. Pure: the same status gives the same text. Missing names become
/// numbers.
StatusText MakeStatusText(const Status& status, const StatusNames& names);

}  // namespace hpdm
