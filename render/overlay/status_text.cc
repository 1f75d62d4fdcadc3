#include "render/overlay/status_text.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "engine/base/angle.h"
#include "engine/exercise/duct_judge.h"
#include "engine/mesh/closest_point.h"
#include "render/overlay/exercise_text.h"
#include "render/overlay/help_page.h"
#include "render/overlay/status_lines.h"

namespace hpdm {
namespace {

double Milli(Nanoseconds duration) { return 1e-6 * static_cast<double>(duration); }

std::string OrganName(const StatusNames& names, int organ) {
  const auto o = static_cast<std::size_t>(organ);
  return o < names.organs.size() ? names.organs[o] : Format("organ %d", organ + 1);
}

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

// Adds a line with the reason if the guard limits the force.
void AddGuardLine(std::uint32_t flags, std::vector<StatusLine>* lines) {
  if ((flags & kGuardDeviceInvalid) != 0) {
    lines->push_back({"device lost", Tone::kAlarm});
  } else if ((flags & kGuardPaused) != 0) {
    return;  // no patch is new and no force comes in a pause
  } else if ((flags & kGuardDisabled) != 0) {
    lines->push_back({"force off", Tone::kWarning});
  } else if ((flags & kGuardStalePatch) != 0) {
    lines->push_back({"simulation behind"});
  } else if ((flags & kGuardClamped) != 0) {
    lines->push_back({"device at its limit", Tone::kWarning});
  }
}

// Returns the value of the instrument that a tool is; 0 or false if the names do not have it.
template <class T>
T OfInstrument(const std::vector<std::vector<T>>& values, int tool, int instrument_index) {
  const auto t = static_cast<std::size_t>(tool), i = static_cast<std::size_t>(instrument_index);
  return t < values.size() && i < values[t].size() ? T{values[t][i]} : T{};
}

struct NearestDuct {
  std::size_t duct = 0;
  double gap = std::numeric_limits<double>::infinity();  // m, from a point to its surface
  Vector3d near_W = Vector3d::Zero();                    // on its axis
};

NearestDuct NearestDuctTo(const Vector3d& p_W, const SceneSnapshot& scene,
                          const StatusNames& names) {
  NearestDuct nearest;
  for (std::size_t d = 0; d < std::min(scene.ducts.size(), names.duct_radii.size()); ++d) {
    const DuctSnapshot& duct = scene.ducts[d];
    for (int i = 0; i + 1 < duct.nodes; ++i) {
      if (duct.segments[ToSize(i)] == SegmentState::kGap) continue;
      const Vector3d a_W = duct.nodes_W[ToSize(i)].cast<double>();
      const Vector3d b_W = duct.nodes_W[ToSize(i + 1)].cast<double>();
      const Vector3d near_W = a_W + ClosestOnSegment(p_W, a_W, b_W) * (b_W - a_W);
      const double gap = (p_W - near_W).norm() - names.duct_radii[d];
      if (gap < nearest.gap) nearest = {d, gap, near_W};
    }
  }
  return nearest;
}

// m from which on the way to a target along the shaft is told, and the least share of it along the shaft.
constexpr double kWayShown = 0.002, kAlongShaft = 0.7;

// Returns "12 mm from bed", and which way along the shaft the bed is, if it lies ahead or behind.
StatusLine GapLine(const ToolPose& pose, const Vector3d& from_W, const Vector3d& to_W, double gap,
                   const std::string& target) {
  const Vector3d way_W = to_W - from_W;
  const double out = pose.X_WT.linear().col(2).dot(way_W);
  const char* way = "";
  if (gap >= kWayShown && std::abs(out) > kAlongShaft * way_W.norm()) {
    way = out < 0 ? ": push in" : ": pull back";
  }
  return {Format("%.0f mm from ", 1e3 * std::max(0.0, gap)) + target + way, Tone::kDim};
}

// m up to which jaws that close on ducts are said to be near one.
constexpr double kDuctShown = 0.06;
// The same for a hook or scissors and the layer that the exercise asks to free.
constexpr double kLayerShown = 0.04;

// Returns how far an instrument is from its target: jaws that close on ducts, with their middle, from one, a
// hook from the layer to free.
std::optional<StatusLine> TargetLine(const Status& status, const StatusNames& names, int tool) {
  const ToolPose& pose = status.scene.tools[tool];
  if (const double jaws = OfInstrument(names.duct_jaws, tool, pose.instrument_index); jaws > 0) {
    const Vector3d middle_W = pose.X_WT * Vector3d(0, 0, jaws / 2);
    const auto [duct, gap, near_W] = NearestDuctTo(middle_W, status.scene, names);
    if (gap < kDuctShown) return GapLine(pose, middle_W, near_W, gap, names.ducts[duct]);
  }
  if (const std::optional<Vector3d>& to_W = status.to_free_W[ToSize(tool)];
      status.to_free >= 0 && to_W &&
      OfInstrument(names.frees_layers, tool, pose.instrument_index)) {
    const Vector3d tip_W = pose.X_WT.translation();
    const double gap = (*to_W - tip_W).norm();
    if (gap < kLayerShown) {
      return GapLine(pose, tip_W, *to_W, gap, names.layers[ToSize(status.to_free)]);
    }
  }
  return std::nullopt;
}

// Returns how deep the tip is in the organ that it presses.
StatusLine DepthLine(const Status& status, const StatusNames& names, int tool) {
  const SessionHealth::Tool& health = status.health.tools[tool];
  return {Format("%.1f mm into ", 1e3 * health.depth) + OrganName(names, health.organ),
          health.depth > status.limits.depth ? Tone::kAlarm : Tone::kPlain};
}

// m: a press less deep does not hide what a hook burns.
constexpr double kDepthShown = 0.001;

// Adds what the tip does: "holds liver", "in loose tissue" for a hook that would burn it, "3.2 mm into
// liver", "12 mm from liver", or "free" if no organ is near; and how far its target is.
void AddContactLines(const Status& status, const StatusNames& names, int tool,
                     std::vector<StatusLine>* lines) {
  const SessionHealth::Tool& health = status.health.tools[tool];
  const SolvedContact& contact = status.scene.contacts[tool];
  if (contact.kind == ContactKind::kGrasp && contact.organ >= 0) {
    lines->push_back({"holds " + OrganName(names, contact.organ), Tone::kGood});
    return;
  }
  const auto layer = static_cast<std::size_t>(status.scene.readouts[tool].layer);
  if (status.scene.readouts[tool].layer >= 0 && layer < names.layers.size()) {
    const bool wanted = status.to_free < 0 || ToSize(status.to_free) == layer;
    lines->push_back({"in " + names.layers[layer] + (wanted ? "" : ": not yet"),
                      wanted ? Tone::kGood : Tone::kWarning});
    if (health.organ >= 0 && health.depth > kDepthShown) {
      lines->push_back(DepthLine(status, names, tool));
      lines->back().tone = std::max(lines->back().tone, Tone::kWarning);
    }
    return;
  }
  const std::optional<StatusLine> target = TargetLine(status, names, tool);
  if (health.organ >= 0) lines->push_back(DepthLine(status, names, tool));
  if (target) lines->push_back(*target);
  if (target || health.organ >= 0) return;
  if (contact.organ < 0) {
    lines->push_back({"free", Tone::kDim});
    return;
  }
  const ToolPose& pose = status.scene.tools[tool];
  const double distance = (pose.X_WT.translation() - contact.contact_W).norm() -
                          OfInstrument(names.tip_radii, tool, pose.instrument_index);
  lines->push_back(
      {Format("%.0f mm from ", 1e3 * std::max(0.0, distance)) + OrganName(names, contact.organ),
       Tone::kDim});
}

// s for which a closing that found no duct is shown, and m up to which it was near one.
constexpr double kMissShown = 6, kMissNear = 0.015;

// rad: a roll that hardly changes a clip.
constexpr double kLittleRoll = 5 * kDegree;

// Adds the duct between the open jaws of a clip applier and how a clip would lie on it.
void AddClipAhead(const Status& status, const StatusNames& names, int tool,
                  std::vector<StatusLine>* lines) {
  const ToolReadout& readout = status.scene.readouts[tool];
  const DuctAction& clip = readout.clip_ahead;
  const auto duct = static_cast<std::size_t>(clip.duct);
  if (clip.duct < 0 || duct >= names.ducts.size()) return;
  lines->push_back({"in jaws: " + names.ducts[duct], Tone::kGood});
  if (readout.clips_left < 0) {  // scissors cut at any angle, and what they reach into
    const int organ = status.health.tools[tool].organ;
    if (organ >= 0) lines->push_back({"and " + OrganName(names, organ), Tone::kWarning});
    return;
  }
  if (clip.coverage < DuctJudge::kLeastCoverage) {
    const ToolPose& pose = status.scene.tools[tool];
    const double jaws = OfInstrument(names.duct_jaws, tool, pose.instrument_index);
    const bool at_tip = (pose.X_WT.inverse() * clip.place_W).z() < jaws / 2;
    lines->push_back({at_tip ? "push in to cover it" : "pull back to cover it", Tone::kWarning});
  }
  if (const double gap = readout.clip_gap - DuctJudge::kClipWidth; gap < DuctJudge::kLeastGap) {
    lines->push_back({Format("%.1f mm from a clip: %g needed", 1e3 * std::max(0.0, gap),
                             1e3 * DuctJudge::kLeastGap),
                      Tone::kWarning});
  }
  const double angle = clip.angle / kDegree, roll = readout.clip_roll;
  if (std::abs(roll) >= kLittleRoll) {
    lines->push_back({Format("%.0f\u00b0 oblique: roll %.0f\u00b0, %s", angle,
                             std::abs(roll) / kDegree, roll > 0 ? "e" : "q"),
                      clip.angle > kClipAngle ? Tone::kWarning : Tone::kPlain});
  } else if (clip.angle > kClipAngle) {
    lines->push_back(
        {Format("%.0f\u00b0 oblique: turn the tube, other hand", angle), Tone::kWarning});
  } else {
    lines->push_back({Format("%.0f\u00b0 oblique: good", angle), Tone::kGood});
  }
}

// Adds what a clip applier's magazine holds, and what jaws have just missed.
void AddReadout(const Status& status, const StatusNames& names, int tool,
                std::vector<StatusLine>* lines) {
  const ToolReadout& readout = status.scene.readouts[tool];
  if (readout.closed_empty) {
    lines->push_back({"empty: exchange it for a full one (x)", Tone::kAlarm});
  } else if (readout.clips_left >= 0) {
    lines->push_back({Format("clips left: %d", readout.clips_left),
                      readout.clips_left == 0 ? Tone::kWarning : Tone::kPlain});
  }
  AddClipAhead(status, names, tool, lines);
  const auto duct = static_cast<std::size_t>(readout.missed_duct);
  const double age = ToSeconds(status.scene.step.time_ns - readout.missed_ns);
  if (readout.missed_duct < 0 || duct >= names.ducts.size() || age > kMissShown ||
      readout.missed_by > kMissNear) {
    return;
  }
  lines->push_back({"no duct between jaws:", Tone::kWarning});
  lines->push_back(
      {Format("%.0f mm from ", 1e3 * readout.missed_by) + names.ducts[duct], Tone::kWarning});
}

std::vector<StatusLine> ToolLines(const Status& status, const StatusNames& names, int tool) {
  const SessionHealth::Tool& health = status.health.tools[tool];
  const bool active = status.view.window_width > 0 && tool == status.view.active_instrument;
  std::vector<StatusLine> lines;
  AddGuardLine(health.guard_flags, &lines);
  lines.push_back({(active ? "\u25b8 " : "") +
                       InstrumentName(names, tool, status.scene.tools[tool].instrument_index),
                   active ? Tone::kGood : Tone::kPlain});
  if (status.outside[static_cast<std::size_t>(tool)]) {
    lines.push_back({"outside the picture", active ? Tone::kWarning : Tone::kDim});
    const bool holds = status.scene.contacts[tool].kind == ContactKind::kGrasp &&
                       status.scene.contacts[tool].organ >= 0;
    if (active && !holds) lines.push_back({"wheel up brings it in", Tone::kWarning});
  }
  AddReadout(status, names, tool, &lines);
  AddContactLines(status, names, tool, &lines);
  const double force = health.force_W.norm(), limit = status.limits.force;
  lines.push_back({Format("%.2f N", force), force > limit ? Tone::kAlarm : Tone::kPlain,
                   std::clamp(force / (kBarLimits * limit), 0.0, 1.0)});
  lines.push_back({Format("peak %.2f N", health.peak_force), Tone::kDim});
  return lines;
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
  if (guides && !exercise.ended)
    text.guidance = GuidanceLines(exercise, *names.exercise, status.view.paused);
  if (guides && exercise.ended) {
    text.banner = ResultLines(exercise, *names.exercise);
    text.alarms.clear();
  }
  return text;
}

}  // namespace hpdm
