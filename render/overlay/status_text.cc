#include "render/overlay/status_text.h"

#include <algorithm>
#include <cstdarg>
#include <cstdio>

namespace hpdm {
namespace {

__attribute__((format(printf, 1, 2))) std::string Text(const char* format, ...) {
  char text[120];
  std::va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return text;
}

double Milli(Nanoseconds duration) { return 1e-6 * static_cast<double>(duration); }

std::string InstrumentName(const StatusNames& names, int tool, int instrument_index) {
  const auto t = static_cast<std::size_t>(tool), e = static_cast<std::size_t>(instrument_index);
  if (t < names.instruments.size() && e < names.instruments[t].size()) {
    return names.instruments[t][e];
  }
  return Text("instrument %d", tool + 1);
}

std::string OrganName(const StatusNames& names, int organ) {
  const auto o = static_cast<std::size_t>(organ);
  return o < names.organs.size() ? names.organs[o] : Text("organ %d", organ + 1);
}

// Lines for the trainer: they stay below warnings, so that a trainee looks at the tissue.
std::vector<StatusLine> LoopLines(const Status& status) {
  const SessionHealth& health = status.health;
  std::vector<StatusLine> lines;
  if (health.haptic_hz > 0) {
    lines.push_back({Text("haptics %.0f Hz, late %.0f \u00b5s (p99)", health.haptic_hz,
                          1e-3 * static_cast<double>(health.wake_late_p99_ns)),
                     Tone::kDim});
    lines.push_back(
        {Text("deformation %.0f Hz, %.1f ms", health.deformation_hz, Milli(health.step_compute_ns)),
         health.step_flags == 0 ? Tone::kDim : Tone::kPlain});
  }
  if ((health.step_flags & kStepRecovering) != 0) {
    lines.push_back({"overstretched", Tone::kWarning});
  } else if ((health.step_flags & kStepInverted) != 0) {
    lines.push_back({"tissue inverted", Tone::kWarning});
  }
  if ((health.step_flags & kStepShed) != 0) lines.push_back({"reduced quality"});
  if (status.frame_hz > 0) {
    lines.push_back({Text("picture %.0f Hz", status.frame_hz), Tone::kDim});
  }
  if (health.ticks > 0) {
    const std::uint32_t skipped = health.skipped.Total();
    lines.push_back({Text("ticks missed: %u", skipped), skipped == 0 ? Tone::kDim : Tone::kPlain});
  }
  if (health.log_lost > 0) {
    lines.push_back(
        {Text("log lost %llu", static_cast<unsigned long long>(health.log_lost)), Tone::kAlarm});
  }
  return lines;
}

std::string ClockText(Nanoseconds time_ns) {
  const auto seconds = static_cast<long long>(ToSeconds(time_ns));
  const long long hours = seconds / 3600, minutes = seconds / 60 % 60;
  return hours > 0 ? Text("%lld:%02lld:%02lld", hours, minutes, seconds % 60)
                   : Text("%lld:%02lld", minutes, seconds % 60);
}

// Lines that answer the user.
void AddNotices(const Status& status, const StatusNames& names, std::vector<StatusLine>* lines) {
  const ViewSettings& view = status.view;
  if (view.recording) lines->push_back({"\u25cf recording", Tone::kAlarm});
  if (!status.screenshot.empty()) lines->push_back({status.screenshot, Tone::kGood});
  if (view.window_width == 0) return;
  for (int tool = 0; tool < status.scene.tool_count; ++tool) {
    const int wanted = view.wanted_instrument[tool];
    if (wanted == status.scene.tools[tool].instrument_index) continue;
    lines->push_back(
        {InstrumentName(names, tool, wanted) + ": free the tip to take it", Tone::kGood});
  }
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
  if (view.overlays & kOverlayForce) {
    lines.push_back({Text("colours: force 0 to %g N", kForceScale)});
  }
  if ((view.overlays & kOverlayError) && status.error_scale > 0) {
    lines.push_back({Text("colours: error 0 to %g mm", 1e3 * status.error_scale)});
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
          {who + Text("%.0f mm deep, limit %.3g mm", 1e3 * health.depth, 1e3 * limits.depth),
           Tone::kAlarm});
    }
    if (const double force = health.force_W.norm(); force > limits.force) {
      lines.push_back({who + Text("%.1f N, limit %.3g N", force, limits.force), Tone::kAlarm});
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

// Adds a line with the reason if the guard limits the force.
void AddGuardLine(std::uint32_t flags, std::vector<StatusLine>* lines) {
  if ((flags & kGuardDeviceInvalid) != 0) {
    lines->push_back({"device lost", Tone::kAlarm});
  } else if ((flags & kGuardDisabled) != 0) {
    lines->push_back({"force off", Tone::kWarning});
  } else if ((flags & kGuardStalePatch) != 0) {
    lines->push_back({"simulation behind"});
  } else if ((flags & kGuardClamped) != 0) {
    lines->push_back({"device at its limit", Tone::kWarning});
  }
}

// Returns what the tip does: "holds liver", "3.2 mm liver" or "free".
StatusLine ContactLine(const Status& status, const StatusNames& names, int tool) {
  const SessionHealth::Tool& health = status.health.tools[tool];
  const SolvedContact& contact = status.scene.contacts[tool];
  if (contact.kind == ContactKind::kGrasp && contact.organ >= 0) {
    return {"holds " + OrganName(names, contact.organ), Tone::kGood};
  }
  if (health.organ < 0) return {"free", Tone::kDim};
  return {Text("%.1f mm ", 1e3 * health.depth) + OrganName(names, health.organ),
          health.depth > status.limits.depth ? Tone::kAlarm : Tone::kPlain};
}

std::vector<StatusLine> ToolLines(const Status& status, const StatusNames& names, int tool) {
  const SessionHealth::Tool& health = status.health.tools[tool];
  const bool active = status.view.window_width > 0 && tool == status.view.active_instrument;
  std::vector<StatusLine> lines;
  AddGuardLine(health.guard_flags, &lines);
  lines.push_back({(active ? "\u25b8 " : "") +
                       InstrumentName(names, tool, status.scene.tools[tool].instrument_index),
                   active ? Tone::kGood : Tone::kPlain});
  lines.push_back(ContactLine(status, names, tool));
  const double force = health.force_W.norm(), limit = status.limits.force;
  lines.push_back({Text("%.2f N", force), force > limit ? Tone::kAlarm : Tone::kPlain,
                   std::clamp(force / (kBarLimits * limit), 0.0, 1.0)});
  lines.push_back({Text("peak %.2f N", health.peak_force), Tone::kDim});
  return lines;
}

// s for which an error stays on the screen.
constexpr double kErrorShown = 4;

// Adds a text in lines of up to about 44 bytes.
void AddWrapped(const std::string& text, Tone tone, std::vector<StatusLine>* lines) {
  constexpr std::size_t kMaxLine = 44;
  for (std::size_t begin = 0; begin < text.size();) {
    std::size_t end = text.size();
    if (end - begin > kMaxLine) {
      const std::size_t space = text.rfind(' ', begin + kMaxLine);
      end = space == std::string::npos || space <= begin ? text.find(' ', begin + kMaxLine) : space;
      end = std::min(end, text.size());
    }
    lines->push_back({text.substr(begin, end - begin), tone});
    begin = end + 1;
  }
}

// Returns the present step, how far it is, and the last error for a while.
std::vector<StatusLine> GuidanceLines(const ExerciseStatus& status,
                                      const ExerciseOptions& exercise) {
  std::vector<StatusLine> lines;
  const auto step = static_cast<std::size_t>(status.step);
  if (status.last_error >= 0 && status.time - status.last_error_time < kErrorShown) {
    AddWrapped(exercise.errors[static_cast<std::size_t>(status.last_error)].name, Tone::kAlarm,
               &lines);
  }
  if (step < exercise.steps.size()) {
    AddWrapped(Text("%zu/%zu ", step + 1, exercise.steps.size()) + exercise.steps[step].instruction,
               Tone::kGood, &lines);
    if (status.progress > 0) lines.push_back({Text("%.0f %%", 100 * status.progress)});
  }
  lines.push_back({Text("%.0f s left, %d %s, score %.0f", status.time_left, status.errors,
                        status.errors == 1 ? "error" : "errors", status.score),
                   Tone::kDim});
  return lines;
}

std::vector<StatusLine> ResultLines(const ExerciseStatus& status, const ExerciseOptions& exercise) {
  return {{status.passed ? "EXERCISE DONE" : "TIME IS OVER",
           status.passed ? Tone::kGood : Tone::kWarning},
          {exercise.name},
          {Text("%d of %zu steps, %d %s", status.step, exercise.steps.size(), status.errors,
                status.errors == 1 ? "error" : "errors")},
          {Text("%.1f s", status.time)},
          {Text("score %.0f of 100", status.score), Tone::kGood}};
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

std::vector<StatusLine> Keys() {
  const auto key = [](const char* keys, const char* what) {
    return StatusLine{what, Tone::kPlain, {}, keys};
  };
  return {
      {"Instrument", Tone::kGood},
      key("click, Space", "hold it with the mouse; Space releases it"),
      key("mouse, wheel", "move the tip, push it in and out"),
      key("left button, j", "close the jaws"),
      key("right button, q e", "roll"),
      key("Tab, 1 to 4", "another instrument; what the last one holds stays held"),
      key("x", "exchange it"),
      key("d", "pedal: the hook burns, suction sucks while held"),
      {"Second hand, or a gamepad", Tone::kGood},
      key("t g f h", "move the tip"),
      key("y b, c n, v", "push in and out, roll, close the jaws"),
      {"Laparoscope", Tone::kGood},
      key("arrows, Shift + mouse", "turn"),
      key("PgUp PgDn, Shift + wheel", "in and out"),
      key("+ \u2212", "zoom"),
      key("a", "optics of 0, 30, 45\u00b0"),
      key(", .", "turn the optics"),
      {"Session", Tone::kGood},
      key("p", "pause"),
      key("i", "guidance of an exercise"),
      key("s, r", "screenshot, record"),
      key("o", "overlays"),
      key("F1", "show the keys"),
      key("Esc", "end"),
  };
}

}  // namespace

StatusText MakeStatusText(const Status& status, const StatusNames& names) {
  StatusText text;
  const bool shows_text = (status.view.overlays & kOverlayText) != 0;
  if (shows_text) {
    text.loops = LoopLines(status);
    for (int tool = 0; tool < std::min(status.scene.tool_count, status.health.tool_count); ++tool) {
      text.tools[tool] = ToolLines(status, names, tool);
    }
    text.state = StateLines(status, names);
    text.on_right = SidesOf(status, names);
  }
  if (shows_text || status.view.window_width > 0) {
    AddNotices(status, names, &text.state);
    text.alarms = AlarmLines(status, names);
  }
  if (status.marks != nullptr) text.marks = MarksOf(status);
  const ExerciseStatus& exercise = status.health.exercise;
  const bool guides = status.view.guidance && names.exercise && exercise.present;
  if (guides && !exercise.ended) text.guidance = GuidanceLines(exercise, *names.exercise);
  // The banner answers the user, so it appears even without the rest of the text.
  if (status.view.help) {
    text.banner = Keys();
  } else if (status.view.paused) {
    text.banner = {{"PAUSED", Tone::kWarning}, {"p: resume"}};
  } else if (guides && exercise.ended) {
    text.banner = ResultLines(exercise, *names.exercise);
  }
  return text;
}

}  // namespace hpdm
