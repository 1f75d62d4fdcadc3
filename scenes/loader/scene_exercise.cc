#include <algorithm>
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

// Returns the attachment of the organ under `key`; with `from`, that to the other organ.
std::optional<int> ReadAttachmentIndex(const TableReader& table, std::string_view key,
                                       std::string_view from, const Scene& scene) {
  const std::optional<int> organ = ReadOrganIndex(table, key, scene);
  if (!organ) return {};
  const std::optional<int> other = from.empty() ? std::nullopt : ReadOrganIndex(table, from, scene);
  const auto joins = [&](const AttachmentOptions& attachment, std::optional<int> index) {
    if (!index) return true;
    const std::string& name = scene.organs[static_cast<std::size_t>(*index)].name;
    return attachment.a == name || attachment.b == name;
  };
  std::optional<int> found;
  for (std::size_t a = 0; a < scene.attachments.size(); ++a) {
    if (!joins(scene.attachments[a], organ) || !joins(scene.attachments[a], other)) continue;
    if (found) {
      table.Fail(
          key, "has several attachments",
          from.empty() ? "leave it out to watch all of them" : "name the other organ as from");
    }
    found = static_cast<int>(a);
  }
  if (!found) table.Fail(key, "has no such attachment", "name an organ of an [[attachment]]");
  return found;
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
  RequireBeside(table, "at", "touch");
  RequireBeside(table, "at", "within");
  RequireBeside(table, "within", "at");
  Vector3d at_W = Vector3d::Zero();
  if (table.ReadVector("at", kCoordinate, &at_W)) step.at_W = at_W;
  table.ReadNumber("within", Interval::Positive(1, "m"), &step.within);
  step.frees = ReadAttachmentIndex(table, "free", "from", scene);
  RequireBeside(table, "from", "free");
  RequireBeside(table, "area", "free");
  RequireBeside(table, "free", "area");
  table.ReadNumber("area", Interval::Positive(kMaxArea, "m^2"), &step.freed_area);
  step.releases = ReadOrganIndex(table, "release", scene);
  double force = 0;
  if (table.ReadNumber("force", Interval::Positive(kMaxTissueForce, "N"), &force)) {
    step.force = force;
  }
  table.ReadNumber("time", Interval::NotNegative(kMaxTime, "s"), &step.time);
  if (!step.holds && !step.touches && !step.frees && !step.releases && !step.force) {
    table.Fail("has no condition", "give one of hold, touch, free, release and force");
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
    {ExerciseErrorKind::kDrop, "tissue dropped", 0.01},
    {ExerciseErrorKind::kInverted, "tissue overstretched", 0},
};

ExerciseErrorOptions ReadError(const TableReader& table, const Scene& scene) {
  ExerciseErrorOptions error;
  table.Require("kind", "give the kind of error");
  table.ReadChoice("kind",
                   {{"force", ExerciseErrorKind::kForce},
                    {"tear", ExerciseErrorKind::kTear},
                    {"burn", ExerciseErrorKind::kBurn},
                    {"stray_burn", ExerciseErrorKind::kStrayBurn},
                    {"drop", ExerciseErrorKind::kDrop},
                    {"inverted", ExerciseErrorKind::kInverted}},
                   &error.kind);
  const ErrorKind& kind = *std::ranges::find(kKinds, error.kind, &ErrorKind::kind);
  error.name = kind.name;
  error.limit = kind.limit;
  table.ReadName("name", &error.name);
  if (error.kind == ExerciseErrorKind::kTear) {
    error.attachment = ReadAttachmentIndex(table, "organ", {}, scene).value_or(-1);
  } else {
    error.organ = ReadOrganIndex(table, "organ", scene).value_or(-1);
  }
  const bool of_organ =
      error.kind != ExerciseErrorKind::kStrayBurn && error.kind != ExerciseErrorKind::kInverted;
  if (!of_organ && table.Has("organ")) {
    table.Fail("organ", "does not belong to this kind of error", "remove it");
  }
  if (error.kind == ExerciseErrorKind::kInverted && table.Has("limit")) {
    table.Fail("limit", "does not belong to this kind of error", "remove it");
  }
  table.ReadNumber("limit", Interval::Positive(1000, "N, m^2, s or m"), &error.limit);
  table.ReadNumber("points", Interval::NotNegative(100, ""), &error.points);
  return error;
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
  table.Require("step", "add at least one [[exercise.step]] table");
  for (const TableReader& step : table.Tables("step", kExerciseStepKeys, kMaxExerciseSteps)) {
    exercise.steps.push_back(ReadStep(step, scene));
  }
  if (exercise.steps.empty()) {
    table.Fail("step", "is empty", "add at least one [[exercise.step]] table");
  }
  for (const TableReader& error : table.Tables("error", kExerciseErrorKeys, kMaxExerciseErrors)) {
    exercise.errors.push_back(ReadError(error, scene));
  }
  for (std::size_t hand = 0; hand < scene.instruments.size(); ++hand) {
    for (int held = 0; held < scene.instruments[hand].HeldCount(); ++held) {
      if (scene.instruments[hand].Held(held).type == InstrumentType::kHook) {
        exercise.hooks.push_back({static_cast<int>(hand), held});
      }
    }
  }
  return exercise;
}

}  // namespace hpdm
