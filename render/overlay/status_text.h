#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "engine/snapshots.h"
#include "render/overlay/view_settings.h"

namespace hpdm {

/// Names of what the text speaks of, by index.
struct StatusNames {
  std::vector<std::string> organs;
  std::vector<std::vector<std::string>> instruments;  ///< [tool][ToolPose::instrument_index].
};

/// What the text tells of, at one frame.
struct Status {
  const ViewSettings& view;
  const SessionHealth& health;  ///< As it is before the first: without ticks.
  const SceneSnapshot& scene;
  double frame_hz = 0;     ///< Pictures a second lately; 0: unknown.
  double error_scale = 0;  ///< OrganVisual::error_scale; 0: there is no reference.
};

enum class Tone { kPlain, kDim, kGood, kWarning, kAlarm };

struct StatusLine {
  std::string text;
  Tone tone = Tone::kPlain;
  std::optional<double> bar = {};  ///< A bar beside the text, 0 empty .. 1 full.
  std::string key = {};            ///< Of the banner: a column before the text.
};

/// The text by its place: in the corners that the circular picture leaves free, and over its
/// middle.
struct StatusText {
  std::vector<StatusLine> loops;                               ///< Top left: rates and losses.
  std::vector<StatusLine> state;                               ///< Top right: recording, hints.
  std::array<std::vector<StatusLine>, kMaxInstruments> tools;  ///< Bottom left and right.
  std::vector<StatusLine> banner;                              ///< Middle: PAUSED, or the keys.
};

/// Force that fills the bar, N: above what careful handling of soft organs takes (1 to 3 N).
inline constexpr double kBarForce = 5;

/// What the picture says: pure, so that the same status gives the same text. Names that are missing
/// become numbers.
StatusText MakeStatusText(const Status& status, const StatusNames& names);

}  // namespace hpdm
