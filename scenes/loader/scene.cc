#include "scenes/loader/scene.h"

#include <cmath>
#include <utility>

#include "engine/base/quoted_token.h"
#include "engine/base/text_list.h"
#include "engine/snapshots.h"
#include "scenes/loader/scene_keys.h"
#include "scenes/loader/scene_parts.h"

namespace hpdm {
namespace {

TimingOptions ReadTiming(const TableReader& table) {
  TimingOptions timing;
  table.ReadInteger("haptic_hz", 100, 10000, &timing.haptic_hz);
  table.ReadInteger("deformation_hz", 1, 1000, &timing.deformation_hz);
  table.ReadInteger("render_hz", 1, 240, &timing.render_hz);
  if (timing.deformation_hz > timing.haptic_hz) {
    table.Fail("deformation_hz", "is above haptic_hz = " + std::to_string(timing.haptic_hz),
               "give at most haptic_hz");
  }
  timing.patch_delay_ticks = (timing.haptic_hz + timing.deformation_hz - 1) / timing.deformation_hz;
  table.ReadInteger("patch_delay_ticks", 1, 10000, &timing.patch_delay_ticks);
  table.ReadNumber("step_budget", {.min = 0, .max = 1}, &timing.step_budget);
  return timing;
}

LaparoscopeOptions ReadLaparoscope(const TableReader& table) {
  LaparoscopeOptions scope;
  table.ReadVector("position", kCoordinate, &scope.p_scope_W);
  table.ReadVector("target", kCoordinate, &scope.p_target_W);
  if ((scope.p_target_W - scope.p_scope_W).norm() <= kScopeNear) {
    table.Fail("target", "is within 2 mm of position", "give a point farther from the tip");
  }
  Vector3d trocar = Vector3d::Zero();
  if (table.ReadVector("trocar", kCoordinate, &trocar)) {
    scope.p_trocar_W = trocar;
    if ((trocar - scope.p_scope_W).norm() <= kScopeNear) {
      table.Fail("trocar", "is within 2 mm of position", "give a point farther from the tip");
    }
  }
  int angle_deg = 0;
  table.ReadInteger("angle_deg", 0, 45, &angle_deg);
  table.RefuseOthers("angle_deg", {0, 30, 45}, "is not a laparoscope's angle",
                     "give 0, 30 or 45 degrees");
  scope.angle = Radians(angle_deg);

  table.RefuseBoth("field_of_view_deg", "focal_length");
  double field_of_view_deg = 0, focal_length = 0;
  if (table.ReadNumber("field_of_view_deg", {.min = 10, .max = 120, .unit = "degrees"},
                       &field_of_view_deg)) {
    scope.field_of_view = Radians(field_of_view_deg);
  }
  if (table.ReadNumber("focal_length", {.min = 0.0015, .max = 0.025, .unit = "m"}, &focal_length)) {
    scope.field_of_view = FieldOfView(focal_length);
  }
  table.ReadNumber("distortion", {.min = -0.3, .max = 0.3, .unit = ""}, &scope.distortion);
  return scope;
}

// The port and the device belong to a side of the body, the instrument to a hand.
void ExchangePorts(InstrumentOptions* a, InstrumentOptions* b) {
  std::swap(a->p_trocar_W, b->p_trocar_W);
  std::swap(a->trocar_friction, b->trocar_friction);
  std::swap(a->trocar_torque, b->trocar_torque);
  std::swap(a->device, b->device);
}

template <typename Options>
void RefuseTakenName(const TableReader& table, const Options& added,
                     const std::vector<Options>& others) {
  for (const Options& other : others) {
    if (other.name == added.name) {
      table.Fail("name", "is already used", "give each one its own name");
    }
  }
}

}  // namespace

void RequireOrgan(const TableReader& table, std::string_view key, const std::string& name,
                  const std::vector<OrganOptions>& organs) {
  std::string names;
  for (const OrganOptions& organ : organs) {
    if (organ.name == name) return;
    AppendToList(Quoted(organ.name), &names);
  }
  table.Fail(key, "is not the name of an organ", "the scene's organs are " + names);
}

void ReadRotation(const TableReader& table, std::string_view key, Matrix3d* rotation) {
  Vector3d degrees;
  if (!table.ReadVector(key, Interval::Within(360, "degrees"), &degrees)) return;
  const Eigen::AngleAxisd about_x(Radians(degrees.x()), Vector3d::UnitX());
  const Eigen::AngleAxisd about_y(Radians(degrees.y()), Vector3d::UnitY());
  const Eigen::AngleAxisd about_z(Radians(degrees.z()), Vector3d::UnitZ());
  *rotation = (about_z * about_y * about_x).toRotationMatrix();
}

Scene ReadScene(const TomlDocument& document, KeyObserver* observer) {
  Scene scene;
  scene.path = document.path;
  scene.source_text = document.text;
  scene.name = document.path.stem().string();

  SceneFiles files(document.path.parent_path());
  const TableReader root(document, kRootKeys, &files, observer);
  files.ReadEntries(root);
  Vector3d gravity_W = Vector3d::Zero();
  if (const auto table = root.Table("scene", kSceneKeys)) {
    table->ReadName("name", &scene.name);
    table->ReadVector("gravity", Interval::Within(100, "m/s^2"), &gravity_W);
    table->ReadFile("background", &scene.background);
    table->ReadBoolean("left_handed", &scene.left_handed);
  }
  if (const auto table = root.Table("timing", kTimingKeys)) scene.timing = ReadTiming(*table);

  constexpr std::string_view kAddOrgan = "add at least one [[organ]] table";
  root.Require("organ", kAddOrgan);
  for (const TableReader& table : root.Tables("organ", kOrganKeys, kMaxOrgans)) {
    OrganOptions organ = ReadOrgan(table);
    organ.time_step = 1.0 / scene.timing.deformation_hz;
    organ.gravity_W = gravity_W;
    RefuseTakenName(table, organ, scene.organs);
    scene.organs.push_back(std::move(organ));
  }
  std::size_t layers = 0;
  for (const OrganOptions& organ : scene.organs) layers += organ.layers.size();
  if (layers > kMaxLayers) {
    root.Fail("organ", "has more than " + std::to_string(kMaxLayers) + " tables [[organ.layer]]",
              "give fewer of them");
  }
  if (scene.organs.empty()) root.Fail("organ", "is empty", kAddOrgan);
  for (const TableReader& table : root.Tables("contact", kContactKeys, kMaxContactPairs)) {
    ReadContact(table, &scene.organs);
  }
  for (const TableReader& table : root.Tables("attachment", kAttachmentKeys, kMaxAttachments)) {
    AttachmentOptions attachment = ReadAttachment(table, scene.organs);
    if (!attachment.name.empty()) RefuseTakenName(table, attachment, scene.attachments);
    scene.attachments.push_back(std::move(attachment));
  }
  for (const TableReader& table : root.Tables("duct", kDuctKeys, kMaxDucts)) {
    DuctOptions duct = ReadDuct(table, scene.organs, scene.attachments);
    RefuseTakenName(table, duct, scene.ducts);
    scene.ducts.push_back(std::move(duct));
  }
  int cuts = 0;
  for (const TableReader& table : root.Tables("cut", kCutKeys, kMaxCuts)) {
    ReadCut(table, cuts++, &scene.organs);
  }
  for (const TableReader& table : root.Tables("instrument", kInstrumentKeys, kMaxInstruments)) {
    InstrumentOptions instrument = ReadInstrument(table, scene.organs);
    RefuseTakenName(table, instrument, scene.instruments);
    scene.instruments.push_back(std::move(instrument));
  }
  if (scene.left_handed) {
    if (scene.instruments.size() < 2) {
      root.Table("scene", kSceneKeys)
          ->Fail("left_handed", "needs two instruments, which exchange their ports",
                 "remove it or add an [[instrument]]");
    }
    ExchangePorts(&scene.instruments[0], &scene.instruments[1]);
  }
  for (const TableReader& table : root.Tables("load", kLoadKeys)) {
    const LoadOptions& load = scene.loads.emplace_back(ReadLoad(table, scene.organs));
    for (OrganOptions& organ : scene.organs) {
      if (organ.name == load.organ) organ.loads.push_back(load);
    }
  }
  if (const auto table = root.Table("exercise", kExerciseKeys)) {
    scene.exercise = ReadExercise(*table, scene);
  }
  if (const auto table = root.Table("laparoscope", kLaparoscopeKeys)) {
    scene.laparoscope = ReadLaparoscope(*table);
  }
  scene.files = files.found();
  scene.recorded = files.recorded();
  return scene;
}

Scene LoadScene(const std::filesystem::path& path) { return ReadScene(ReadToml(path)); }

}  // namespace hpdm
