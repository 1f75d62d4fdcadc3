#include <cstdint>
#include <limits>
#include <utility>

#include "scenes/loader/instrument_types.h"
#include "scenes/loader/scene_keys.h"
#include "scenes/loader/scene_parts.h"

namespace hpdm {
namespace {

constexpr double kMaxRadius = 0.05;  // m; instruments are 5 to 12 mm thick
constexpr double kMaxPower = 400;    // W; electrosurgery uses 20 to 100 W
constexpr int kDefaultClips = 20, kMaxClips = 100;
constexpr double kMaxClosingForce = 100;  // N; laparoscopic graspers close with 5 to 20 N

DeviceProfile ReadDevice(const TableReader& table) {
  enum class Profile { kImpulseEngine };
  Profile profile = Profile::kImpulseEngine;
  table.ReadChoice("profile", {{"impulse_engine", Profile::kImpulseEngine}}, &profile);

  DeviceProfile device;
  table.ReadNumber("mass", Interval::Positive(100, "kg"), &device.mass);
  table.ReadNumber("rotational_inertia", Interval::Positive(100, "kg m^2"),
                   &device.rotational_inertia);
  table.ReadNumber("damping", Interval::NotNegative(1e4, "N s/m"), &device.damping);
  table.ReadNumber("rotational_damping", Interval::NotNegative(1e4, "N m s/rad"),
                   &device.rotational_damping);
  table.ReadNumber("friction", Interval::NotNegative(100, "N"), &device.friction);
  table.ReadNumber("rotational_friction", Interval::NotNegative(100, "N m"),
                   &device.rotational_friction);
  table.ReadNumber("encoder_step", Interval::Positive(0.01, "m"), &device.encoder_step);
  table.ReadNumber("angle_encoder_step", Interval::Positive(0.1, "rad"),
                   &device.angle_encoder_step);
  table.ReadNumber("jaw_encoder_step", Interval::Positive(1, "of the jaw's range"),
                   &device.jaw_encoder_step);
  table.ReadNumber("max_force", Interval::Positive(1000, "N"), &device.max_force);
  table.ReadNumber("max_torque", Interval::Positive(1000, "N m"), &device.max_torque);
  table.ReadNumber("max_force_rate", Interval::Positive(1e6, "N/s"), &device.max_force_rate);
  // Pitch and yaw stay below pi / 2, where the kinematics about the trocar are singular.
  table.ReadNumber("max_angle", Interval::Positive(1.5, "rad"), &device.max_angle);
  table.ReadNumber("min_insertion", Interval::NotNegative(1, "m"), &device.min_insertion);
  table.ReadNumber("max_insertion", Interval::Positive(1, "m"), &device.max_insertion);
  if (device.min_insertion >= device.max_insertion) {
    const std::string_view key = table.Has("max_insertion") ? "max_insertion" : "min_insertion";
    table.Fail(key, "leaves no travel between min_insertion and max_insertion",
               "give max_insertion above min_insertion");
  }
  table.ReadNumber("delay", Interval::NotNegative(0.1, "s"), &device.delay);
  table.ReadBoolean("passivity_control", &device.passivity_control);
  return device;
}

HandOptions ReadHand(const TableReader& table, InstrumentType type,
                     const std::vector<OrganOptions>& organs) {
  HandOptions hand;
  hand.organ = organs.front().name;
  table.ReadChoice("script",
                   {{"palpate", HandScript::kPalpate},
                    {"tap", HandScript::kTap},
                    {"slide", HandScript::kSlide},
                    {"grasp_lift", HandScript::kGraspLift},
                    {"grasp_pull", HandScript::kGraspPull},
                    {"random", HandScript::kRandom}},
                   &hand.script);
  const bool grasps =
      hand.script == HandScript::kGraspLift || hand.script == HandScript::kGraspPull;
  if (grasps && type != InstrumentType::kGrasper) {
    table.Fail("script", "needs an instrument that holds tissue",
               "give the instrument type = \"grasper\"");
  }
  table.ReadInteger<std::uint32_t>("seed", 0, std::numeric_limits<std::uint32_t>::max(),
                                   &hand.seed);
  if (table.ReadString("organ", &hand.organ)) RequireOrgan(table, "organ", hand.organ, organs);
  Vector3d target = Vector3d::Zero();
  if (table.ReadVector("target", kCoordinate, &target)) hand.target = target;
  table.ReadNumber("depth", Interval::Positive(0.5, "m"), &hand.depth);
  table.ReadNumber("spread", Interval::Positive(0.5, "m"), &hand.spread);
  table.ReadNumber("speed", Interval::Positive(5, "m/s"), &hand.speed);
  table.ReadNumber("stiffness", Interval::Positive(1e5, "N/m"), &hand.stiffness);
  table.ReadNumber("damping", Interval::NotNegative(1e4, "N s/m"), &hand.damping);
  table.ReadNumber("tremor", Interval::NotNegative(0.01, "m"), &hand.tremor);
  return hand;
}

TraceOptions ReadTrace(const TableReader& table) {
  TraceOptions trace;
  table.ReadFile("file", &trace.file);
  table.ReadNumber("scale", Interval::Positive(1000, "m per unit of the file"), &trace.scale);
  ReadRotation(table, "rotation_deg", &trace.R_WF);
  Vector3d position = Vector3d::Zero();
  if (table.ReadVector("position", kCoordinate, &position)) trace.position = position;
  table.ReadNumber("speed", {.min = 0.01, .max = 100, .unit = "times as fast as recorded"},
                   &trace.speed);
  return trace;
}

JawOptions ReadJaws(const TableReader& table) {
  JawOptions jaws;
  for (const std::string_view key : {"meshes", "pivot", "opening_deg"}) {
    table.Require(key, "jaws are meshes, a pivot in m and an opening_deg");
  }
  table.ReadFiles("meshes", 2, &jaws.meshes);
  table.ReadNumber("pivot", Interval::NotNegative(1, "m"), &jaws.pivot);
  double opening_deg = 0;
  table.ReadNumber("opening_deg", Interval::Positive(90, "degrees"), &opening_deg);
  jaws.opening = Radians(opening_deg);
  return jaws;
}

constexpr std::string_view kJawForces[] = {"closing_force", "jaw_friction"};

/// Refuses a key of one type of instrument in another.
void RequireType(const TableReader& table, std::string_view key, InstrumentType type,
                 const InstrumentDescription& held) {
  if (held.type == type || !table.Has(key)) return;
  for (const auto& [name, named] : kInstrumentTypes) {
    if (named != type) continue;
    const std::string wanted(name);
    table.Fail(key, "needs type = \"" + wanted + "\"",
               "remove it or give type = \"" + wanted + "\"");
  }
}

/// Reads the keys that an instrument and its exchanges share.
void ReadHeld(const TableReader& table, InstrumentDescription* held) {
  table.Require("name", "name the instrument");
  table.ReadName("name", &held->name);
  table.ReadChoice("type", kInstrumentTypes, &held->type);
  table.ReadFile("mesh", &held->mesh);
  if (table.Has("jaws") && held->mesh.empty()) {
    table.Fail("jaws", "needs mesh",
               "give mesh, the part that does not turn, or remove jaws: each type has its own");
  }
  if (const auto jaws = table.Table("jaws", kJawKeys)) held->jaws = ReadJaws(*jaws);
  double insulated_from = 0;
  if (table.ReadNumber("insulated_from", Interval::NotNegative(1, "m"), &insulated_from)) {
    held->insulated_from = insulated_from;
  }
  table.ReadNumber("tip_radius", Interval::Positive(kMaxRadius, "m"), &held->geometry.tip_radius);
  table.ReadNumber("shaft_radius", Interval::Positive(kMaxRadius, "m"),
                   &held->geometry.shaft_radius);
  table.ReadNumber("friction", Interval::NotNegative(2, ""), &held->geometry.friction);
  for (const std::string_view key : kJawForces) {
    if (held->type != InstrumentType::kGrasper && table.Has(key)) {
      table.Fail(key, "needs jaws that hold tissue", "remove it or give type = \"grasper\"");
    }
  }
  RequireType(table, "power", InstrumentType::kHook, *held);
  table.ReadNumber("power", Interval::Positive(kMaxPower, "W"), &held->geometry.power);
  RequireType(table, "clips", InstrumentType::kClipApplier, *held);
  held->geometry.clips = held->type == InstrumentType::kClipApplier ? kDefaultClips : 0;
  table.ReadInteger("clips", 0, kMaxClips, &held->geometry.clips);
  table.ReadNumber("closing_force", Interval::Positive(kMaxClosingForce, "N"),
                   &held->geometry.closing_force);
  table.ReadNumber("jaw_friction", Interval::Positive(2, ""), &held->geometry.jaw_friction);
}

/// Refuses the keys of jaws that hold tissue by friction, which reaction = "paper" does not know.
void RefuseJawForces(const TableReader& table, const InstrumentOptions& instrument) {
  for (const std::string_view key : kJawForces) {
    if (instrument.reaction == ReactionType::kPaper && table.Has(key)) {
      table.Fail(key, "needs reaction = \"lattice\"", "remove it or change the reaction");
    }
  }
}

void ReadExchanges(const TableReader& table, InstrumentOptions* instrument) {
  for (const TableReader& exchange : table.Tables("exchange", kExchangeKeys, kMaxHeld - 1)) {
    InstrumentDescription held;
    ReadHeld(exchange, &held);
    RefuseJawForces(exchange, *instrument);
    for (int i = 0; i < instrument->HeldCount(); ++i) {
      if (instrument->Held(i).name != held.name) continue;
      exchange.Fail("name", "is already used", "give each instrument of a hand its own name");
    }
    instrument->exchanges.push_back(std::move(held));
  }
}

}  // namespace

InstrumentOptions ReadInstrument(const TableReader& table,
                                 const std::vector<OrganOptions>& organs) {
  InstrumentOptions instrument;
  ReadHeld(table, &instrument);
  table.Require("trocar", "give the point where the shaft enters the body as [x, y, z] in m");
  table.ReadVector("trocar", kCoordinate, &instrument.p_trocar_W);
  table.ReadChoice("reaction",
                   {{"paper", ReactionType::kPaper}, {"lattice", ReactionType::kLattice}},
                   &instrument.reaction);
  RefuseJawForces(table, instrument);
  for (const std::string_view key : {"k1", "k2"}) {
    if (instrument.reaction != ReactionType::kPaper && table.Has(key)) {
      table.Fail(key, "needs reaction = \"paper\"", "remove it or change the reaction");
    }
  }
  table.ReadNumber("k1", Interval::NotNegative(1e5, "N/m"), &instrument.k1);
  table.ReadNumber("k2", Interval::NotNegative(1e5, "N/m"), &instrument.k2);

  table.ReadNumber("trocar_friction", Interval::NotNegative(20, "N"), &instrument.trocar_friction);
  table.ReadNumber("trocar_torque", Interval::NotNegative(1, "N m"), &instrument.trocar_torque);

  if (const auto device = table.Table("device", kDeviceKeys)) {
    instrument.device = ReadDevice(*device);
  }
  instrument.hand.organ = organs.front().name;
  if (const auto hand = table.Table("hand", kHandKeys)) {
    instrument.hand = ReadHand(*hand, instrument.type, organs);
  }
  if (const auto trace = table.Table("trace", kTraceKeys)) instrument.trace = ReadTrace(*trace);
  ReadExchanges(table, &instrument);
  return instrument;
}

}  // namespace hpdm
