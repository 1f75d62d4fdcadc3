#include "render/overlay/tool_text.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "engine/base/angle.h"
#include "engine/exercise/duct_judge.h"
#include "engine/exercise/step_queries.h"
#include "engine/mesh/closest_point.h"
#include "render/overlay/exercise_text.h"
#include "render/overlay/status_lines.h"

namespace hpdm {
namespace {

std::string OrganName(const StatusNames& names, int organ) {
  const auto o = static_cast<std::size_t>(organ);
  return o < names.organs.size() ? names.organs[o] : Format("organ %d", organ + 1);
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

bool HoldsOrgan(const SolvedContact& contact) {
  return contact.kind == ContactKind::kGrasp && contact.organ >= 0;
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

// Returns the exercise's present step; nullptr also while the guidance is switched off.
const ExerciseStepOptions* GuidedStep(const Status& status, const StatusNames& names) {
  return status.view.guidance ? PresentStep(status.health.exercise, names) : nullptr;
}

// True if the present step of the exercise asks for other ducts than this one.
bool AsksForOthers(const Status& status, const StatusNames& names, std::size_t duct) {
  const ExerciseStepOptions* present = GuidedStep(status, names);
  const auto number = static_cast<int>(duct);
  return present != nullptr && (!present->clips.empty() || !present->cuts.empty()) &&
         !Contains(present->clips, number) && !Contains(present->cuts, number);
}

NearestDuct NearestDuctTo(const Vector3d& p_W, const Status& status, const StatusNames& names) {
  const SceneSnapshot& scene = status.scene;
  NearestDuct nearest;
  for (std::size_t d = 0; d < std::min(scene.ducts.size(), names.duct_radii.size()); ++d) {
    if (AsksForOthers(status, names, d)) continue;
    const DuctSnapshot& duct = scene.ducts[d];
    for (int i = 0; i + 1 < duct.nodes; ++i) {
      if (duct.segments[ToSize(i)] == SegmentState::kGap) continue;
      const Vector3d a_W = duct.nodes_W[ToSize(i)].cast<double>();
      const Vector3d b_W = duct.nodes_W[ToSize(i + 1)].cast<double>();
      const Vector3d near_W = ClosestPointOnSegment(p_W, a_W, b_W);
      const double gap = (p_W - near_W).norm() - names.duct_radii[d];
      if (gap < nearest.gap) nearest = {d, gap, near_W};
    }
  }
  return nearest;
}

// m from which on the way to a target is told, and the least share of it that is.
constexpr double kWayShown = 0.0005, kLeastShare = 0.4;

// Returns how the hand moves the tip by `way_W` (m): "push in, left", with the picture's sides.
std::string WayText(const ToolPose& pose, const Isometry3d& X_WC, const Vector3d& way_W) {
  const Vector3d out_W = pose.X_WT.linear().col(2);
  const double out = out_W.dot(way_W), least = kLeastShare * way_W.norm();
  const Vector3d beside_C = X_WC.linear().transpose() * (way_W - out * out_W);
  std::string way;
  if (std::abs(out) > least) way = out < 0 ? "push in" : "pull back";
  const double x = beside_C.x(), y = beside_C.y();
  if (std::max(std::abs(x), std::abs(y)) > least) {
    way += way.empty() ? "" : ", ";
    way += std::abs(x) > std::abs(y) ? (x < 0 ? "left" : "right") : (y < 0 ? "down" : "up");
  }
  return way;
}

// m in front of the lens: the least depth at which a tip is looked for.
constexpr double kLeastView = 0.03;

// Returns the way from a tip to the middle of the picture at its depth, m.
Vector3d IntoPicture_W(const ToolPose& pose, const Isometry3d& X_WC) {
  const Vector3d tip_C = X_WC.inverse() * pose.X_WT.translation();
  const Vector3d middle_C(0, 0, std::min(tip_C.z(), -kLeastView));
  return X_WC.linear() * (middle_C - tip_C);
}

// Adds "to cystic duct" and "12 mm: push in, left": two short lines fit beside the guidance.
void AddWayLines(const Status& status, int tool, const Vector3d& from_W, const Vector3d& to_W,
                 double gap, const std::string& target, std::vector<StatusLine>* lines) {
  lines->push_back({"to " + target, Tone::kDim});
  std::string way;
  if (gap >= kWayShown) way = WayText(status.scene.tools[tool], status.X_WC, to_W - from_W);
  lines->push_back(
      {Format("%.0f mm", 1e3 * std::max(0.0, gap)) + (way.empty() ? "" : ": ") + way, Tone::kDim});
}

// m by which the strands must be longer than a hook is thick, so that it fits between the organs; m up to
// which the hook is told so; and the share of the way to tearing up to which a pull is advised.
constexpr double kRoom = 0.0005, kGapShown = 0.01, kMostPull = 0.6;

// Adds that an instrument does not fit between the organs of the layer to free.
void AddGapLine(const Status& status, const StatusNames& names, int tool,
                std::vector<StatusLine>* lines) {
  const std::optional<NearestFibre>& nearest = status.nearest_to_free[ToSize(tool)];
  if (!nearest) return;
  const double thick =
      2 * OfInstrument(names.tip_radii, tool, status.scene.tools[tool].instrument_index);
  if (nearest->gap >= thick + kRoom || thick == 0) return;
  const char* advice = status.tautness < kMostPull ? ": pull further" : "";
  lines->push_back({Format("gap %.1f mm", 1e3 * nearest->gap) + advice, Tone::kWarning});
}

// m up to which jaws that close on ducts are said to be near one, and to miss it narrowly.
constexpr double kDuctShown = 0.06, kBesideJaws = 0.003;

// Adds how far an instrument is from its target. That of jaws that close on ducts, measured from their
// middle, is the nearest duct that the exercise asks for; that of a hook is the layer to free. False without
// a target.
bool AddTargetLines(const Status& status, const StatusNames& names, int tool,
                    std::vector<StatusLine>* lines) {
  const ToolPose& pose = status.scene.tools[tool];
  if (const double jaws = OfInstrument(names.duct_jaws, tool, pose.instrument_index); jaws > 0) {
    const Vector3d middle_W = pose.X_WT * Vector3d(0, 0, jaws / 2);
    const auto [duct, gap, near_W] = NearestDuctTo(middle_W, status, names);
    if (gap < kDuctShown) {
      // To the tube's axis, which must come between the jaws.
      const double way = (near_W - middle_W).norm();
      AddWayLines(status, tool, middle_W, near_W, way, names.ducts[duct], lines);
      const bool beside = gap < kBesideJaws && pose.jaw >= kJawGrasps;
      if (beside) lines->push_back({"not between the jaws", Tone::kWarning});
      return true;
    }
  }
  if (const std::optional<NearestFibre>& nearest = status.nearest_to_free[ToSize(tool)];
      nearest && ToSize(nearest->attachment) < names.layers.size()) {
    const Vector3d tip_W = pose.X_WT.translation();
    const double distance = (nearest->p_W - tip_W).norm();
    AddWayLines(status, tool, tip_W, nearest->p_W, distance,
                names.layers[ToSize(nearest->attachment)], lines);
    if (distance < kGapShown) AddGapLine(status, names, tool, lines);
    return true;
  }
  return false;
}

// m: a press less deep needs no way out.
constexpr double kDepthShown = 0.001;

// Adds how deep the tip is in the organ that it presses, and the way out of it: "3.2 mm into liver", "out: pull
// back, up".
void AddDepthLines(const Status& status, const StatusNames& names, int tool, Tone least,
                   std::vector<StatusLine>* lines) {
  const SessionHealth::Tool& health = status.health.tools[tool];
  const Tone tone = health.depth > status.limits.depth ? Tone::kAlarm : least;
  lines->push_back(
      {Format("%.1f mm into ", 1e3 * health.depth) + OrganName(names, health.organ), tone});
  const SolvedContact& contact = status.scene.contacts[tool];
  if (health.depth > kDepthShown && contact.organ == health.organ) {
    const std::string way = WayText(status.scene.tools[tool], status.X_WC, contact.normal_W);
    if (!way.empty()) lines->push_back({"out: " + way, tone});
  }
}

// m: an organ as near as this to a hook in a layer is named.
constexpr double kNearOrgan = 0.002;

// Adds how far the nearest organ is from a tip that presses none; false where none is near.
bool AddDistanceLine(const Status& status, const StatusNames& names, int tool, double most,
                     std::vector<StatusLine>* lines) {
  const SolvedContact& contact = status.scene.contacts[tool];
  if (contact.organ < 0) return false;
  const ToolPose& pose = status.scene.tools[tool];
  const double distance = (pose.X_WT.translation() - contact.contact_W).norm() -
                          OfInstrument(names.tip_radii, tool, pose.instrument_index);
  if (distance > most) return false;
  const int decimals = distance < kNearOrgan ? 1 : 0;
  lines->push_back({Format("%.*f mm from ", decimals, 1e3 * std::max(0.0, distance)) +
                        OrganName(names, contact.organ),
                    Tone::kDim});
  return true;
}

// Adds how far what the jaws hold is from the place that the exercise's present step names.
void AddWayOfHeld(const Status& status, const StatusNames& names, int tool,
                  std::vector<StatusLine>* lines) {
  const ExerciseStepOptions* present = GuidedStep(status, names);
  if (present == nullptr || !present->at_W || !present->holds) return;
  const SolvedContact& contact = status.scene.contacts[tool];
  const int held = status.scene.tools[tool].instrument_index;
  if (!IsHold(*present->holds, contact, tool, held)) return;
  const double gap = (*present->at_W - contact.contact_W).norm() - present->within;
  AddWayLines(status, tool, contact.contact_W, *present->at_W, gap, "its place", lines);
}

// Adds what the tip does: "holds liver", "in loose tissue" for a hook that would burn it, "3.2 mm into
// liver", "12 mm from liver", or "free" if no organ is near; and how far its target is.
void AddContactLines(const Status& status, const StatusNames& names, int tool,
                     std::vector<StatusLine>* lines) {
  const SessionHealth::Tool& health = status.health.tools[tool];
  const SolvedContact& contact = status.scene.contacts[tool];
  if (HoldsOrgan(contact)) {
    lines->push_back({"holds " + OrganName(names, contact.organ), Tone::kGood});
    AddWayOfHeld(status, names, tool, lines);
    return;
  }
  const auto layer = static_cast<std::size_t>(status.scene.readouts[tool].layer);
  if (status.scene.readouts[tool].layer >= 0 && layer < names.layers.size()) {
    const bool wanted =
        status.to_free.empty() || Contains(status.to_free, status.scene.readouts[tool].layer);
    lines->push_back({"in " + names.layers[layer] + (wanted ? "" : ": optional"),
                      wanted ? Tone::kGood : Tone::kPlain});
    const bool touches = health.organ >= 0, is_deep = touches && health.depth > kDepthShown;
    if (wanted && !status.to_free.empty()) {
      // Heat that burns a layer spares the organ, so only what outlasts the strands is an error.
      const char* verdict = is_deep ? "do not burn" : touches ? "burn briefly" : "burn now";
      lines->push_back({verdict, is_deep ? Tone::kWarning : Tone::kGood});
    }
    if (wanted) AddGapLine(status, names, tool, lines);
    if (!touches) {
      AddDistanceLine(status, names, tool, kNearOrgan, lines);
    } else if (is_deep) {
      AddDepthLines(status, names, tool, Tone::kWarning, lines);
    } else {
      lines->push_back({"touches " + OrganName(names, health.organ), Tone::kWarning});
    }
    if (!wanted) AddTargetLines(status, names, tool, lines);
    return;
  }
  if (health.organ >= 0) AddDepthLines(status, names, tool, Tone::kPlain, lines);
  if (AddTargetLines(status, names, tool, lines) || health.organ >= 0) return;
  constexpr double kAnyDistance = std::numeric_limits<double>::infinity();
  if (!AddDistanceLine(status, names, tool, kAnyDistance, lines)) {
    lines->push_back({"free", Tone::kDim});
  }
}

// s for which a closing that found no duct is shown, and m up to which it was near one.
constexpr double kMissShown = 6, kMissNear = 0.015;

// rad: a roll that hardly changes a clip.
constexpr double kLittleRoll = 5 * kDegree;

// Adds the step of the exercise that must come before a clip or a cut of the duct in the jaws. True if
// there is one.
bool AddStepBefore(const Status& status, const StatusNames& names, int tool, ExerciseErrorKind kind,
                   std::vector<StatusLine>* lines) {
  if (GuidedStep(status, names) == nullptr) return false;
  const int duct = status.scene.readouts[tool].clip_ahead.duct;
  const int step = StepBefore(*names.exercise, kind, duct, status.health.exercise.step);
  if (step < 0 || ToSize(step) >= names.exercise->steps.size()) return false;
  lines->push_back({"first " + names.exercise->steps[ToSize(step)].name, Tone::kWarning});
  return true;
}

// m up to which scissors tell how far a clip is, and below which they may miss the gap between two.
constexpr double kClipShown = 0.005, kNarrowCut = 0.0005;

// Adds the clips beside the cut, and what scissors reach into. They cut at any angle.
void AddCutAhead(const Status& status, const StatusNames& names, int tool,
                 std::vector<StatusLine>* lines) {
  const ToolReadout& readout = status.scene.readouts[tool];
  const auto duct = ToSize(readout.clip_ahead.duct);
  const int organ = status.health.tools[tool].organ;
  AddStepBefore(status, names, tool, ExerciseErrorKind::kEarlyCut, lines);
  if (organ >= 0) lines->push_back({"and " + OrganName(names, organ), Tone::kWarning});
  const auto& [gap, before, after] = readout.clips_beside;
  if (gap < kClipShown) {
    const double to_clip = std::max(0.0, gap - DuctJudge::kClipWidth / 2);
    lines->push_back({Format("%.1f mm from a clip", 1e3 * to_clip),
                      to_clip < kNarrowCut ? Tone::kWarning : Tone::kDim});
  }
  Tone tone = Tone::kPlain;  // without a guiding exercise nothing judges them
  int organ_end = -1;
  if (status.view.guidance && names.exercise && duct < names.exercise->ducts.size()) {
    const ExerciseDuct& judged = names.exercise->ducts[duct];
    organ_end = judged.organ_end;
    const bool enough =
        DuctJudge::AreEnough(before, after, judged, names.exercise->clips_that_stay);
    tone = enough ? Tone::kGood : Tone::kWarning;
  }
  if (organ_end < 0) {
    lines->push_back({Format("%d and %d clips beside it", before, after), tone});
    return;
  }
  const int leave = organ_end == 0 ? before : after, stay = before + after - leave;
  lines->push_back({Format("%d %s, %d %s out", stay, stay == 1 ? "clip stays" : "clips stay", leave,
                           leave == 1 ? "comes" : "come"),
                    tone});
}

// m by which jaws lift tissue that then draws its ducts along.
constexpr double kTraction = 0.004;

// True if jaws draw an organ away from where it would be without the instruments.
bool AnOrganIsDrawn(const SceneSnapshot& scene) {
  for (int t = 0; t < scene.tool_count; ++t) {
    if (HoldsOrgan(scene.contacts[t]) && LiftOf(scene.contacts[t]) > kTraction) return true;
  }
  return false;
}

// Adds whether a clip applier may close now, and what to mend. With the guidance off only the clip's angle.
void AddClipAhead(const Status& status, const StatusNames& names, int tool,
                  std::vector<StatusLine>* lines) {
  const ToolReadout& readout = status.scene.readouts[tool];
  const DuctAction& clip = readout.clip_ahead;
  std::string angle = Format("%.0f\u00b0 oblique", clip.angle / kDegree);
  if (!status.view.guidance) {
    lines->push_back({angle, Tone::kDim});
    return;
  }
  ExerciseDuct duct;
  double most_angle = kClipAngle;
  if (names.exercise) {
    const std::vector<ExerciseDuct>& ducts = names.exercise->ducts;
    if (ToSize(clip.duct) < ducts.size()) duct = ducts[ToSize(clip.duct)];
    most_angle = ClipAngleOf(*names.exercise, clip.duct);
  }
  const ClipFinding finding = DuctJudge::Examine(clip, readout.clips_beside.gap, duct, most_angle);
  const std::size_t verdict = lines->size();
  lines->emplace_back();
  const bool early = AddStepBefore(status, names, tool, ExerciseErrorKind::kEarlyClip, lines);
  const bool good = !early && finding.faults == kClipSound;
  (*lines)[verdict] = {good ? "close now" : "do not close yet",
                       good ? Tone::kGood : Tone::kWarning};
  if ((finding.faults & kClipShort) != 0) {
    const ToolPose& pose = status.scene.tools[tool];
    const double jaws = OfInstrument(names.duct_jaws, tool, pose.instrument_index);
    const bool at_tip = (pose.X_WT.inverse() * clip.place_W).z() < jaws / 2;
    lines->push_back({at_tip ? "push in to cover it" : "pull back to cover it", Tone::kWarning});
  }
  const auto add_distance = [&](ClipFault fault, double distance, const char* from, double least) {
    if ((finding.faults & fault) == 0) return;
    const std::string is = Format("%.1f mm from ", 1e3 * std::max(0.0, distance)) + from;
    lines->push_back({is + Format(": %g needed", 1e3 * least), Tone::kWarning});
  };
  add_distance(kClipNearClip, finding.to_clip, "a clip", DuctJudge::kLeastGap);
  add_distance(kClipNearEnd, finding.to_end, "its end", DuctJudge::kLeastToEnd);
  const bool oblique = (finding.faults & kClipOblique) != 0;
  const double roll = readout.clip_roll;
  if (std::abs(roll) >= kLittleRoll) {
    angle += Format(": roll %.0f\u00b0, %s", std::abs(roll) / kDegree, roll > 0 ? "e" : "q");
  } else if (oblique) {
    // A pull at the organ is what turns most tubes out of their place across the jaws.
    angle += AnOrganIsDrawn(status.scene) ? ": ease the pull, other hand"
                                          : ": turn the tube, other hand";
  }
  lines->push_back({angle, oblique ? Tone::kWarning : Tone::kDim});
}

// Adds the duct between open jaws, and what closing them would do.
void AddDuctInJaws(const Status& status, const StatusNames& names, int tool,
                   std::vector<StatusLine>* lines) {
  const ToolReadout& readout = status.scene.readouts[tool];
  const int duct = readout.clip_ahead.duct;
  if (duct < 0 || ToSize(duct) >= names.ducts.size()) return;
  lines->push_back({"in jaws: " + names.ducts[ToSize(duct)], Tone::kGood});
  if (readout.clips_left < 0) {
    AddCutAhead(status, names, tool, lines);
  } else {
    AddClipAhead(status, names, tool, lines);
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
  AddDuctInJaws(status, names, tool, lines);
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

// N by which the force on tissue differs from that on the hand where it is shown.
constexpr double kForceShown = 0.5;

}  // namespace

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
    if (active && !HoldsOrgan(status.scene.contacts[tool])) {
      const ToolPose& pose = status.scene.tools[tool];
      const Vector3d way_W = IntoPicture_W(pose, status.X_WC);
      lines.push_back({"to it: " + WayText(pose, status.X_WC, way_W), Tone::kWarning});
    }
  }
  std::vector<StatusLine> facts;
  AddReadout(status, names, tool, &facts);
  AddContactLines(status, names, tool, &facts);
  for (const StatusLine& fact : facts) AddWrapped(fact.text, fact.tone, &lines, kToolLine);
  const double force = health.force_W.norm(), limit = status.limits.force;
  // The hand feels less than the tissue where the guard limits the force.
  const double on_tissue = status.scene.contacts[tool].force_on_tissue_W.norm();
  if (on_tissue > force + kForceShown) {
    lines.push_back({Format("%.1f N on tissue", on_tissue), on_tissue > limit ? Tone::kAlarm
                                                            : on_tissue > limit / 2
                                                                ? Tone::kWarning
                                                                : Tone::kPlain});
  }
  lines.push_back({Format("%.2f N", force), force > limit ? Tone::kAlarm : Tone::kPlain,
                   std::clamp(force / (kBarLimits * limit), 0.0, 1.0)});
  lines.push_back({Format("peak %.2f N", health.peak_force), Tone::kDim});
  return lines;
}

}  // namespace hpdm
