#include <algorithm>
#include <numbers>
#include <span>
#include <string>

#include "engine/base/quoted_token.h"
#include "engine/base/text_list.h"
#include "scenes/loader/scene_keys.h"
#include "scenes/loader/scene_parts.h"

namespace hpdm {
namespace {

constexpr double kMaxTime = 36000;       // s
constexpr double kMaxTissueForce = 100;  // N
constexpr double kMaxArea = 1;           // m^2
constexpr std::size_t kMaxText = 200;    // bytes of a text on the screen

void ReadText(const TableReader& table, std::string_view key, std::string* text) {
  if (table.ReadString(key, text) && text->size() > kMaxText) {
    table.Fail(key, "is longer than " + std::to_string(kMaxText) + " bytes", "give a shorter text");
  }
}

std::optional<int> ReadOrganIndex(const TableReader& table, std::string_view key,
                                  const Scene& scene) {
  std::string name;
  if (!table.ReadString(key, &name)) return {};
  RequireOrgan(table, key, name, scene.organs);
  const auto found = std::ranges::find(scene.organs, name, &OrganOptions::name);
  return static_cast<int>(found - scene.organs.begin());
}

// Returns the instruments of that name, of any hand.
std::vector<ExerciseTool> ReadTools(const TableReader& table, std::string_view key,
                                    const Scene& scene) {
  std::vector<ExerciseTool> tools;
  std::string name, names;
  if (!table.ReadString(key, &name)) return tools;
  for (std::size_t hand = 0; hand < scene.instruments.size(); ++hand) {
    for (int held = 0; held < scene.instruments[hand].HeldCount(); ++held) {
      const std::string& other = scene.instruments[hand].Held(held).name;
      if (other == name) tools.push_back({static_cast<int>(hand), held});
      AppendToList(Quoted(other), &names);
    }
  }
  if (tools.empty()) {
    table.Fail(key, "is not the name of an instrument",
               "the scene's instruments are " + (names.empty() ? "none" : names));
  }
  return tools;
}

// Returns the attachment of that name, or that of the organ under `key`; with `from`, that to the other
// organ.
std::optional<int> ReadAttachmentIndex(const TableReader& table, std::string_view key,
                                       std::string_view from, const Scene& scene) {
  std::string name;
  if (!table.ReadString(key, &name)) return {};
  const auto named = std::ranges::find(scene.attachments, name, &AttachmentOptions::name);
  if (!name.empty() && named != scene.attachments.end()) {
    return static_cast<int>(named - scene.attachments.begin());
  }
  const std::optional<int> organ = ReadOrganIndex(table, key, scene);
  if (!organ) return {};
  const std::optional<int> other = from.empty() ? std::nullopt : ReadOrganIndex(table, from, scene);
  const auto joins = [&](const AttachmentOptions& attachment, std::optional<int> index) {
    if (!index) return true;
    const std::string& joined = scene.organs[static_cast<std::size_t>(*index)].name;
    return attachment.a == joined || attachment.b == joined;
  };
  std::optional<int> found;
  for (std::size_t a = 0; a < scene.attachments.size(); ++a) {
    if (!joins(scene.attachments[a], organ) || !joins(scene.attachments[a], other)) continue;
    if (found) {
      table.Fail(key, "has several attachments",
                 from.empty() ? "give the attachment's name, or leave it out to watch all of them"
                              : "give the attachment's name, or the other organ as from");
    }
    found = static_cast<int>(a);
  }
  if (!found) {
    table.Fail(key, "has no such attachment", "name an [[attachment]] or an organ of one");
  }
  return found;
}

// Returns the attachments of that label, or the one that ReadAttachmentIndex finds.
std::vector<int> ReadAttachments(const TableReader& table, std::string_view key,
                                 std::string_view from, const Scene& scene) {
  std::vector<int> attachments;
  std::string label;
  if (!table.ReadString(key, &label)) return attachments;
  for (std::size_t a = 0; a < scene.attachments.size(); ++a) {
    if (!label.empty() && scene.attachments[a].label == label) {
      attachments.push_back(static_cast<int>(a));
    }
  }
  if (attachments.empty()) attachments = {*ReadAttachmentIndex(table, key, from, scene)};
  return attachments;
}

// Returns the ducts of that name or label.
std::vector<int> ReadDucts(const TableReader& table, std::string_view key, const Scene& scene) {
  std::vector<int> ducts;
  std::string name, names;
  if (!table.ReadString(key, &name)) return ducts;
  for (std::size_t d = 0; d < scene.ducts.size(); ++d) {
    const DuctOptions& duct = scene.ducts[d];
    if (duct.name == name || (!name.empty() && duct.label == name)) {
      ducts.push_back(static_cast<int>(d));
    }
    AppendToList(Quoted(duct.name), &names);
  }
  if (ducts.empty()) {
    table.Fail(key, "is neither the name nor the label of a duct",
               "the scene's ducts are " + (names.empty() ? "none" : names));
  }
  return ducts;
}

std::optional<ExerciseContact> ReadContactOf(const TableReader& table, std::string_view key,
                                             std::string_view with, const Scene& scene) {
  const std::optional<int> organ = ReadOrganIndex(table, key, scene);
  if (!organ) {
    if (table.Has(with)) {
      table.Fail(with, "needs " + std::string(key), "give " + std::string(key) + " or remove it");
    }
    return {};
  }
  return ExerciseContact{*organ, ReadTools(table, with, scene)};
}

void RequireBeside(const TableReader& table, std::string_view key, std::string_view needed) {
  if (!table.Has(key) || table.Has(needed)) return;
  table.Fail(key, "needs " + std::string(needed), "give both or none");
}

ExerciseStepOptions ReadStep(const TableReader& table, const Scene& scene) {
  ExerciseStepOptions step;
  table.Require("name", "name the step");
  table.ReadName("name", &step.name);
  ReadText(table, "instruction", &step.instruction);
  if (step.instruction.empty()) step.instruction = step.name;
  step.holds = ReadContactOf(table, "hold", "hold_with", scene);
  const auto is_grasper = [&scene](const ExerciseTool& tool) {
    const InstrumentOptions& hand = scene.instruments[static_cast<std::size_t>(tool.hand)];
    return hand.Held(tool.instrument_index).type == InstrumentType::kGrasper;
  };
  if (step.holds && !std::ranges::all_of(step.holds->with, is_grasper)) {
    table.Fail("hold_with", "is not a grasper", "name one");
  }
  RequireBeside(table, "lift", "hold");
  table.ReadNumber("lift", Interval::Positive(1, "m"), &step.lift);
  step.touches = ReadContactOf(table, "touch", "touch_with", scene);
  if (!step.holds) RequireBeside(table, "at", "touch");
  RequireBeside(table, "at", "within");
  RequireBeside(table, "within", "at");
  Vector3d at_W = Vector3d::Zero();
  if (table.ReadVector("at", kCoordinate, &at_W)) step.at_W = at_W;
  table.ReadNumber("within", Interval::Positive(1, "m"), &step.within);
  step.frees = ReadAttachments(table, "free", "from", scene);
  RequireBeside(table, "from", "free");
  RequireBeside(table, "area", "free");
  RequireBeside(table, "free", "area");
  table.ReadNumber("area", Interval::Positive(kMaxArea, "m^2"), &step.freed_area);
  step.clips = ReadDucts(table, "clip", scene);
  RequireBeside(table, "clips", "clip");
  table.ReadInteger("clips", 1, 20, &step.clip_count);
  step.cuts = ReadDucts(table, "cut", scene);
  step.releases = ReadOrganIndex(table, "release", scene);
  double force = 0;
  if (table.ReadNumber("force", Interval::Positive(kMaxTissueForce, "N"), &force)) {
    step.force = force;
  }
  table.ReadNumber("time", Interval::NotNegative(kMaxTime, "s"), &step.time);
  if (!step.holds && !step.touches && step.frees.empty() && step.clips.empty() &&
      step.cuts.empty() && !step.releases && !step.force) {
    table.Fail("has no condition", "give one of hold, touch, free, clip, cut, release and force");
  }
  return step;
}

struct ErrorKind {
  ExerciseErrorKind kind;
  const char* name;
  double limit;
};
constexpr ErrorKind kKinds[] = {
    {ExerciseErrorKind::kForce, "force on tissue above the limit", 4},
    {ExerciseErrorKind::kTear, "tear", 1e-5},
    {ExerciseErrorKind::kBurn, "burn of an organ", 0.3},
    {ExerciseErrorKind::kStrayBurn, "hook energised away from tissue", 0.5},
    {ExerciseErrorKind::kNearBurn, "burn too near", 0.1},
    {ExerciseErrorKind::kDrop, "tissue dropped", 0.01},
    {ExerciseErrorKind::kInverted, "tissue overstretched", 0},
    {ExerciseErrorKind::kBadClip, "clip badly placed", kClipAngle},
    {ExerciseErrorKind::kWrongClip, "clip on the wrong structure", 0},
    {ExerciseErrorKind::kLostClip, "clip lost", 0},
    {ExerciseErrorKind::kWrongCut, "cut into the wrong structure", 0},
    {ExerciseErrorKind::kEarlyClip, "clipped too early", 0},
    {ExerciseErrorKind::kEarlyCut, "cut too early", 0},
    {ExerciseErrorKind::kBadCut, "cut outside the clips", 0},
    {ExerciseErrorKind::kBleeding, "bleeding not stopped in time", 20},
    {ExerciseErrorKind::kPerforation, "perforation of an organ", 0},
    {ExerciseErrorKind::kStretch, "duct overstretched", 1.5},
};
constexpr ExerciseErrorKind kWithOrgan[] = {
    ExerciseErrorKind::kForce,   ExerciseErrorKind::kTear,      ExerciseErrorKind::kBurn,
    ExerciseErrorKind::kDrop,    ExerciseErrorKind::kWrongClip, ExerciseErrorKind::kPerforation,
    ExerciseErrorKind::kWrongCut};
constexpr ExerciseErrorKind kWithDuct[] = {
    ExerciseErrorKind::kBadClip,  ExerciseErrorKind::kWrongClip, ExerciseErrorKind::kEarlyClip,
    ExerciseErrorKind::kEarlyCut, ExerciseErrorKind::kBadCut,    ExerciseErrorKind::kStretch,
    ExerciseErrorKind::kNearBurn};
constexpr double kMostStretch = 10;  // times a duct's first length
constexpr double kDegree = std::numbers::pi / 180;

bool IsOneOf(std::span<const ExerciseErrorKind> kinds, ExerciseErrorKind kind) {
  return std::ranges::find(kinds, kind) != kinds.end();
}

void RefuseOther(const TableReader& table, std::string_view key) {
  if (table.Has(key)) table.Fail(key, "does not belong to this kind of error", "remove it");
}

// Reads the step before whose end the early kinds are errors.
int ReadBefore(const TableReader& table, const std::vector<ExerciseStepOptions>& steps) {
  table.Require("before", "name the step that must be done first");
  std::string name;
  table.ReadString("before", &name);
  const auto found = std::ranges::find(steps, name, &ExerciseStepOptions::name);
  if (found == steps.end()) {
    table.Fail("before", "is not the name of a step", "name an [[exercise.step]]");
  }
  return static_cast<int>(found - steps.begin());
}

// Reads the line that the tip must not be near, if no duct is named, or along which an organ may be laid
// down.
void ReadNearness(const TableReader& table, ExerciseErrorOptions* error) {
  if (error->kind == ExerciseErrorKind::kNearBurn) {
    if (!table.Has("duct")) {
      table.Require("path",
                    "give the points of a line in m, such as a bile duct's axis, or a duct");
    } else if (table.Has("path")) {
      table.Fail("path", "cannot be combined with a duct", "leave one out");
    }
    table.Require("within", "give the distance in m");
  } else if (error->kind == ExerciseErrorKind::kDrop) {
    RequireBeside(table, "path", "within");
    RequireBeside(table, "within", "path");
    if (table.Has("path")) RefuseOther(table, "limit");
  } else {
    RefuseOther(table, "path");
    RefuseOther(table, "within");
  }
  table.ReadPoints("path", kCoordinate, kMaxPathPoints, &error->path_W);
  table.ReadNumber("within", Interval::Positive(1, "m"), &error->within);
}

// Refuses a perforation that cannot happen.
void RequireLumen(const TableReader& table, int organ, const Scene& scene) {
  const auto leaks = [](const OrganOptions& options) {
    return !options.lumens.empty() && HasLeakingLumens(options);
  };
  if (organ >= 0 && !leaks(scene.organs[static_cast<std::size_t>(organ)])) {
    table.Fail("organ", "has no lumen that can leak", "give it an [[organ.lumen]]");
  }
  if (organ < 0 && std::ranges::none_of(scene.organs, leaks)) {
    table.Fail("needs a lumen that can leak", "give an organ an [[organ.lumen]]");
  }
}

ExerciseErrorOptions ReadError(const TableReader& table, const Scene& scene,
                               const std::vector<ExerciseStepOptions>& steps) {
  ExerciseErrorOptions error;
  table.Require("kind", "give the kind of error");
  table.ReadChoice("kind",
                   {{"force", ExerciseErrorKind::kForce},
                    {"tear", ExerciseErrorKind::kTear},
                    {"burn", ExerciseErrorKind::kBurn},
                    {"stray_burn", ExerciseErrorKind::kStrayBurn},
                    {"near_burn", ExerciseErrorKind::kNearBurn},
                    {"drop", ExerciseErrorKind::kDrop},
                    {"inverted", ExerciseErrorKind::kInverted},
                    {"bad_clip", ExerciseErrorKind::kBadClip},
                    {"wrong_clip", ExerciseErrorKind::kWrongClip},
                    {"dropped_clip", ExerciseErrorKind::kLostClip},
                    {"wrong_cut", ExerciseErrorKind::kWrongCut},
                    {"early_clip", ExerciseErrorKind::kEarlyClip},
                    {"early_cut", ExerciseErrorKind::kEarlyCut},
                    {"cut_outside_clips", ExerciseErrorKind::kBadCut},
                    {"bleeding", ExerciseErrorKind::kBleeding},
                    {"perforation", ExerciseErrorKind::kPerforation},
                    {"stretch", ExerciseErrorKind::kStretch}},
                   &error.kind);
  const ErrorKind& kind = *std::ranges::find(kKinds, error.kind, &ErrorKind::kind);
  error.name = kind.name;
  error.limit = kind.limit;
  table.ReadName("name", &error.name);
  if (!IsOneOf(kWithOrgan, error.kind)) RefuseOther(table, "organ");
  if (!IsOneOf(kWithDuct, error.kind)) RefuseOther(table, "duct");
  if (error.kind == ExerciseErrorKind::kTear) {
    error.attachment = ReadAttachmentIndex(table, "organ", {}, scene).value_or(-1);
  } else {
    error.organ = ReadOrganIndex(table, "organ", scene).value_or(-1);
  }
  if (error.kind == ExerciseErrorKind::kWrongCut) {
    table.Require("organ", "name the organ that must not be cut");
  }
  error.ducts = ReadDucts(table, "duct", scene);
  if (error.kind == ExerciseErrorKind::kWrongClip && error.ducts.empty() && error.organ < 0) {
    table.Fail("has neither duct nor organ",
               "name the ducts that may be clipped, or an organ that must not be");
  }
  if (error.kind == ExerciseErrorKind::kStretch && scene.ducts.empty()) {
    table.Fail("needs a duct that can be pulled", "give the scene a [[duct]]");
  }
  if (error.kind == ExerciseErrorKind::kPerforation) RequireLumen(table, error.organ, scene);
  ReadNearness(table, &error);
  if (error.kind == ExerciseErrorKind::kEarlyClip || error.kind == ExerciseErrorKind::kEarlyCut) {
    error.before = ReadBefore(table, steps);
  } else {
    RefuseOther(table, "before");
  }
  if (error.kind == ExerciseErrorKind::kBadClip) {
    double angle = kClipAngle / kDegree;
    table.ReadNumber("limit", Interval::Positive(90, "deg"), &angle);
    error.limit = kDegree * angle;
  } else if (error.kind == ExerciseErrorKind::kStretch) {
    const Interval longer{.min = 1, .max = kMostStretch, .unit = "", .above_min = true};
    table.ReadNumber("limit", longer, &error.limit);
  } else {
    if (kind.limit == 0) RefuseOther(table, "limit");
    table.ReadNumber("limit", Interval::Positive(1000, "N, m^2, s or m"), &error.limit);
  }
  table.ReadNumber("points", Interval::NotNegative(100, ""), &error.points);
  return error;
}

// Reads which organ is taken out, and so which end of each duct goes with it.
std::vector<ExerciseDuct> ReadRemoved(const TableReader& table, const Scene& scene) {
  const std::optional<int> organ = ReadOrganIndex(table, "removes", scene);
  std::vector<ExerciseDuct> ducts;
  for (const DuctOptions& options : scene.ducts) {
    ExerciseDuct& duct = ducts.emplace_back(ExerciseDuct{.name = options.name});
    if (!organ) continue;
    const std::string& name = scene.organs[static_cast<std::size_t>(*organ)].name;
    if (options.a == name) duct.organ_end = 0;
    if (options.b == name && options.a != name) duct.organ_end = 1;
  }
  return ducts;
}

}  // namespace

ExerciseOptions ReadExercise(const TableReader& table, const Scene& scene) {
  ExerciseOptions exercise;
  exercise.name = scene.name;
  table.ReadName("name", &exercise.name);
  ReadText(table, "goal", &exercise.goal);
  table.ReadNumber("time_limit", Interval::Positive(kMaxTime, "s"), &exercise.time_limit);
  exercise.target_time = exercise.time_limit / 2;
  table.ReadNumber("target_time", Interval::Positive(kMaxTime, "s"), &exercise.target_time);
  if (!(exercise.target_time < exercise.time_limit)) {
    table.Fail(table.Has("target_time") ? "target_time" : "time_limit",
               "leaves no time between target_time and time_limit",
               "give a target_time below time_limit");
  }
  exercise.ducts = ReadRemoved(table, scene);
  for (const OrganOptions& organ : scene.organs) exercise.organs.push_back(organ.name);
  table.ReadInteger("stay", 1, 5, &exercise.clips_that_stay);
  table.Require("step", "add at least one [[exercise.step]] table");
  for (const TableReader& step : table.Tables("step", kExerciseStepKeys, kMaxExerciseSteps)) {
    exercise.steps.push_back(ReadStep(step, scene));
  }
  if (exercise.steps.empty()) {
    table.Fail("step", "is empty", "add at least one [[exercise.step]] table");
  }
  for (const TableReader& error : table.Tables("error", kExerciseErrorKeys, kMaxExerciseErrors)) {
    exercise.errors.push_back(ReadError(error, scene, exercise.steps));
  }
  for (std::size_t hand = 0; hand < scene.instruments.size(); ++hand) {
    for (int held = 0; held < scene.instruments[hand].HeldCount(); ++held) {
      const ExerciseTool tool{static_cast<int>(hand), held};
      const InstrumentType type = scene.instruments[hand].Held(held).type;
      if (type == InstrumentType::kHook) exercise.hooks.push_back(tool);
      if (type == InstrumentType::kScissors) exercise.scissors.push_back(tool);
    }
  }
  return exercise;
}

}  // namespace hpdm
