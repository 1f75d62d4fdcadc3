#include "render/overlay/status_text.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "engine/base/angle.h"
#include "render/overlay/exercise_text.h"
#include "render/overlay/help_page.h"
#include "render/overlay/status_lines.h"
#include "render/overlay/tool_text.h"

namespace hpdm {
namespace {

double Milli(Nanoseconds duration) { return 1e-6 * static_cast<double>(duration); }

// Lines for the trainer: they stay below warnings, so that a trainee looks at the tissue.
std::vector<StatusLine> LoopLines(const Status& status) {
  const SessionHealth& health = status.health;
  std::vector<StatusLine> lines;
  if (health.haptic_hz > 0) {
    lines.push_back({Format("haptics %.0f Hz, late %.0f \u00b5s (p99)", health.haptic_hz,
                            1e-3 * static_cast<double>(health.wake_late_p99_ns)),
                     Tone::kDim});
    lines.push_back({Format("deformation %.0f Hz, %.1f ms", health.deformation_hz,
                            Milli(health.step_compute_ns)),
                     health.step_flags == 0 ? Tone::kDim : Tone::kPlain});
  }
  if ((health.step_flags & kStepRecovering) != 0) {
    lines.push_back({"overstretched", Tone::kWarning});
  } else if ((health.step_flags & kStepInverted) != 0) {
    lines.push_back({"tissue inverted", Tone::kWarning});
  }
  if ((health.step_flags & kStepShed) != 0) lines.push_back({"reduced quality"});
  if (status.frame_hz > 0) {
    lines.push_back({Format("picture %.0f Hz", status.frame_hz), Tone::kDim});
  }
  if (health.ticks > 0) {
    const std::uint32_t skipped = health.skipped.Total();
    lines.push_back(
        {Format("ticks missed: %u", skipped), skipped == 0 ? Tone::kDim : Tone::kPlain});
  }
  if (health.log_lost > 0) {
    lines.push_back(
        {Format("log lost %llu", static_cast<unsigned long long>(health.log_lost)), Tone::kAlarm});
  }
  return lines;
}

std::string ClockText(Nanoseconds time_ns) {
  const auto seconds = static_cast<long long>(ToSeconds(time_ns));
  const long long hours = seconds / 3600, minutes = seconds / 60 % 60;
  return hours > 0 ? Format("%lld:%02lld:%02lld", hours, minutes, seconds % 60)
                   : Format("%lld:%02lld", minutes, seconds % 60);
}

// Lines that answer the user.
void AddNotices(const Status& status, std::vector<StatusLine>* lines) {
  const ViewSettings& view = status.view;
  if (view.recording) lines->push_back({"\u25cf recording", Tone::kAlarm});
  if (!status.screenshot.empty()) lines->push_back({status.screenshot, Tone::kGood});
}

// Returns the lines of a window that stand above the alarms: a pause, and exchanges that wait.
std::vector<StatusLine> WaitingLines(const Status& status, const StatusNames& names) {
  std::vector<StatusLine> lines;
  const ViewSettings& view = status.view;
  const bool ended = status.health.exercise.present && status.health.exercise.ended;
  if (view.paused && !ended) lines.push_back({"PAUSED, p: resume", Tone::kWarning});
  if (view.window_width == 0) return lines;
  for (int tool = 0; tool < status.scene.tool_count; ++tool) {
    const int wanted = view.wanted_instrument[tool];
    if (wanted == status.scene.tools[tool].instrument_index) continue;
    lines.push_back({ExchangeOrder(names, tool, wanted), Tone::kGood});
    lines.push_back(
        {InstrumentName(names, tool, wanted) + ": free the tip to take it", Tone::kGood});
  }
  return lines;
}

// Returns the optics' angle and turn if they are not those of the scene. Empty if they are.
std::string OpticsText(const Status& status) {
  const double turn = status.optics_turn / kDegree, angle = status.view.scope.angle / kDegree;
  const bool turned = std::abs(turn) >= 3;  // a turn of the scope turns them a little
  if (!turned && std::abs(status.optics_changed) < 1e-6) return {};
  return Format("optics %.0f\u00b0", angle) + (turned ? Format(", turned %.0f\u00b0", turn) : "");
}

std::vector<StatusLine> StateLines(const Status& status, const StatusNames& names) {
  std::vector<StatusLine> lines = {{ClockText(status.scene.step.time_ns)}};
  const ViewSettings& view = status.view;
  if (view.click_takes) {
    const int active = view.active_instrument;
    const int instrument_index =
        active < status.scene.tool_count ? status.scene.tools[active].instrument_index : 0;
    lines.push_back(
        {"click: take the " + InstrumentName(names, active, instrument_index), Tone::kGood});
  }
  if (view.window_width > 0) lines.push_back({"F1: keys", Tone::kDim});
  if (const std::string optics = OpticsText(status); !optics.empty()) {
    lines.push_back({optics});
    if (view.window_width > 0) lines.push_back({"Home: first view", Tone::kDim});
  }
  if (view.overlays & kOverlayForce) {
    lines.push_back({Format("colours: force 0 to %g N", kForceScale)});
  }
  if ((view.overlays & kOverlayError) && status.error_scale > 0) {
    lines.push_back({Format("colours: error 0 to %g mm", 1e3 * status.error_scale)});
  }
  return lines;
}

// Returns a line for each hand above a limit.
std::vector<StatusLine> AlarmLines(const Status& status, const StatusNames& names) {
  std::vector<StatusLine> lines;
  const HandlingLimits& limits = status.limits;
  for (int tool = 0; tool < std::min(status.scene.tool_count, status.health.tool_count); ++tool) {
    const SessionHealth::Tool& health = status.health.tools[tool];
    const std::string who =
        InstrumentName(names, tool, status.scene.tools[tool].instrument_index) + ": ";
    if (health.depth > limits.depth) {
      lines.push_back(
          {who + Format("%.0f mm deep, limit %.3g mm", 1e3 * health.depth, 1e3 * limits.depth),
           Tone::kAlarm});
    }
    if (const double force = health.force_W.norm(); force > limits.force) {
      lines.push_back({who + Format("%.1f N, limit %.3g N", force, limits.force), Tone::kAlarm});
    }
  }
  return lines;
}

// Puts each tool's text on the side of the picture from which its shaft comes.
std::array<bool, kMaxInstruments> SidesOf(const Status& status, const StatusNames& names) {
  std::array<bool, kMaxInstruments> on_right = StatusText().on_right;
  const std::size_t count = names.trocars_W.size();
  std::array<double, kMaxInstruments> to_right{};
  for (std::size_t t = 0; t < count; ++t) {
    to_right[t] = (status.X_WC.inverse() * names.trocars_W[t]).x();
  }
  if (count == 1) {
    on_right[0] = to_right[0] > 0;
    return on_right;
  }
  // The half that comes from farther right.
  for (std::size_t t = 0; t < count; ++t) {
    std::size_t farther_left = 0;
    for (std::size_t other = 0; other < count; ++other) {
      farther_left +=
          to_right[other] < to_right[t] || (to_right[other] == to_right[t] && other < t);
    }
    on_right[t] = 2 * farther_left >= count;
  }
  return on_right;
}

// Radii of marks in heights of the picture. A bleeding grows for 15 s.
constexpr double kPointRadius = 0.035, kBleedingRadius = 0.015, kBleedingGrowth = 0.004;
constexpr double kBleedingGrows = 15;  // s

// True if a suction tube has its tip in the disc.
bool IsSucked(const StatusMark& disc, const Status& status) {
  for (std::size_t t = 0; t < ToSize(status.scene.tool_count); ++t) {
    const std::optional<Eigen::Vector2d>& tip = status.tips[t];
    if (!status.scene.sucks[t] || !tip) continue;
    const double across = (tip->x() - disc.x) * status.aspect, down = tip->y() - disc.y;
    if (std::hypot(across, down) <= disc.radius) return true;
  }
  return false;
}

std::vector<StatusMark> MarksOf(const Status& status) {
  const PictureMarks& marks = *status.marks;
  const Nanoseconds now = status.scene.step.time_ns;
  std::vector<StatusMark> drawn;
  for (int m = 0; m < marks.count; ++m) {
    const PictureMark& mark = marks.marks[static_cast<std::size_t>(m)];
    StatusMark& one = drawn.emplace_back();
    one.kind = mark.kind;
    one.x = mark.x;
    one.y = mark.y;
    const std::string text = mark.text.data();
    if (mark.kind == PictureMark::Kind::kPoint) {
      one.radius = kPointRadius;
      one.line = {text, Tone::kWarning};
    } else {
      const double age = std::clamp(ToSeconds(now - mark.since_ns), 0.0, kBleedingGrows);
      one.radius = kBleedingRadius + kBleedingGrowth * age;
      if (IsSucked(one, status)) one.radius = kBleedingRadius;
      one.line = {"bleeding" + (text.empty() ? "" : ": " + text), Tone::kAlarm};
    }
  }
  return drawn;
}

}  // namespace

StatusText MakeStatusText(const Status& status, const StatusNames& names) {
  StatusText text;
  // The page of keys stands alone.
  if (status.view.help) {
    text.banner = HelpPage(status, names);
    return text;
  }
  const bool shows_text = (status.view.overlays & kOverlayText) != 0;
  if (shows_text) {
    text.loops = LoopLines(status);
    for (int tool = 0; tool < std::min(status.scene.tool_count, status.health.tool_count); ++tool) {
      text.tools[tool] = ToolLines(status, names, tool);
    }
    text.state = StateLines(status, names);
    text.on_right = SidesOf(status, names);
  }
  // These answer the user, so a window has them even without the rest of the text.
  text.alarms = WaitingLines(status, names);
  if (shows_text || status.view.window_width > 0) {
    AddNotices(status, &text.state);
    std::ranges::move(AlarmLines(status, names), std::back_inserter(text.alarms));
  }
  if (status.marks != nullptr) text.marks = MarksOf(status);
  const ExerciseStatus& exercise = status.health.exercise;
  const bool guides = status.view.guidance && names.exercise && exercise.present;
  if (guides && !exercise.ended) {
    text.guidance = GuidanceLines(exercise, *names.exercise, status.tautness, status.view.paused);
    if (status.view.paused)  // in the corner, for the guidance is over the tissue
      std::ranges::move(ErrorLines(exercise, *names.exercise), std::back_inserter(text.state));
  }
  if (guides && exercise.ended) {
    text.banner = ResultLines(exercise, *names.exercise);
    text.alarms.clear();
  }
  return text;
}

}  // namespace hpdm
