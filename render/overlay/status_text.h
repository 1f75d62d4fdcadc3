#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/handling_limits.h"
#include "engine/exercise/exercise_options.h"
#include "engine/snapshots.h"
#include "render/overlay/nearest_fibre.h"
#include "render/overlay/picture_marks.h"
#include "render/overlay/view_settings.h"

namespace hpdm {

/// Names in the text, by index, and the hands' places.
struct StatusNames {
  std::vector<std::string> organs;
  std::vector<std::vector<std::string>> instruments;  ///< [tool][ToolPose::instrument_index].
  std::vector<Vector3d> trocars_W = {};  ///< By tool, m: they decide on which side its text stands.
  std::optional<ExerciseOptions> exercise = {};
  std::vector<std::string> layers = {};  ///< Of the attachments.
  std::vector<std::string> ducts = {};
  std::vector<double> duct_radii = {};              ///< m.
  std::vector<std::vector<double>> tip_radii = {};  ///< As `instruments`, m.
  /// As `instruments`: length of the jaws that close on ducts, m; 0 without any.
  std::vector<std::vector<double>> duct_jaws = {};
  std::vector<std::vector<bool>> frees_layers = {};  ///< As `instruments`: a hook or scissors.
};

/// Inputs of the text at one frame.
struct Status {
  const ViewSettings& view;
  const SessionHealth& health;  ///< Default-constructed before the first.
  const SceneSnapshot& scene;
  double frame_hz = 0;     ///< Pictures per second; 0: unknown.
  double error_scale = 0;  ///< OrganVisual::error_scale; 0: without a reference.
  HandlingLimits limits = {};
  Isometry3d X_WC = Isometry3d::Identity();  ///< The camera's pose, x to the right.
  std::string screenshot = {};  ///< "saved NAME" for a while after a screenshot; else empty.
  const PictureMarks* marks = nullptr;  ///< Of a teacher; null: none.
  /// Where each tool's tip is, 0..1 of the picture from its left and top. None: it is behind the lens.
  std::array<std::optional<Eigen::Vector2d>, kMaxInstruments> tips = {};
  /// Attachments that the exercise asks to free next, and what is left of them nearest to the tip of each
  /// tool that frees layers.
  std::vector<int> to_free = {};
  std::array<std::optional<NearestFibre>, kMaxInstruments> nearest_to_free = {};
  double tautness = 0;      ///< Their largest share of the way to tearing, 0..1.
  double aspect = 4.0 / 3;  ///< Width of the picture over its height.
  std::array<bool, kMaxInstruments> outside{};  ///< The tip is outside the circular picture.
  double optics_turn = 0;                       ///< rad about the shaft, from the first view's.
  double optics_changed = 0;  ///< rad: the optics' angle less that of the first view.
};

enum class Tone { kPlain, kDim, kGood, kWarning, kAlarm };

struct StatusLine {
  std::string text;
  Tone tone = Tone::kPlain;
  std::optional<double> bar = {};  ///< A bar beside the text, 0 empty .. 1 full.
  std::string key = {};            ///< Column before the text of the banner.
};

/// A teacher's mark as it is drawn: a frame, or the disc of a bleeding, with a text beside it.
struct StatusMark {
  PictureMark::Kind kind = PictureMark::Kind::kPoint;
  double x = 0, y = 0;  ///< 0..1 of the picture.
  double radius = 0;    ///< Of its height.
  StatusLine line;
};

/// The text by its place: the corners outside the circular picture, and boxes over its top, middle and
/// bottom. A window has the notices (recording, a screenshot) and the box at the top even without
/// kOverlayText. The page of keys stands alone.
struct StatusText {
  std::vector<StatusLine> loops;                               ///< Top left: rates and losses.
  std::vector<StatusLine> state;                               ///< Top right: clock, notices.
  std::array<std::vector<StatusLine>, kMaxInstruments> tools;  ///< Bottom left and right.
  std::array<bool, kMaxInstruments> on_right = {false, true, false, true};  ///< Of each.
  std::vector<StatusLine> alarms;    ///< Top of the circle: PAUSED, a pending exchange, limits.
  std::vector<StatusLine> guidance;  ///< Bottom of the circle: the exercise.
  std::vector<StatusLine> banner;    ///< Middle: the keys, or an exercise's result.
  std::vector<StatusMark> marks = {};
};

/// The bar is full at this many force limits.
inline constexpr double kBarLimits = 5. / 3;

/// Returns the picture's text. Pure: the same status gives the same text. Missing names become
/// numbers.
StatusText MakeStatusText(const Status& status, const StatusNames& names);

}  // namespace hpdm
