#include "tools/session/session.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/base/check.h"
#include "engine/base/error.h"
#include "engine/pairs/organ_overlap.h"
#include "engine/tissue/support.h"
#include "haptics/device/external_device.h"
#include "haptics/device/sim_device.h"
#include "haptics/device/simulated_hand.h"
#include "haptics/device/trace_device.h"
#include "render/overlay/overlay_renderer.h"
#include "tools/session/hand_site.h"
#include "tools/session/instrument_meshes.h"
#include "tools/session/scene_defaults.h"
#include "tools/session/trace_remark.h"
#include "tools/shared/report_text.h"
#include "tools/shared/static_case.h"
#include "tools/shared/with_scene_path.h"

namespace hpdm {
namespace {

constexpr double kMouseStart = 0.03;  // m, from a mouse's first position to the tissue

std::vector<ToolGeometry> GeometriesOf(const InstrumentOptions& instrument) {
  std::vector<ToolGeometry> geometries;
  for (int held = 0; held < instrument.HeldCount(); ++held) {
    geometries.push_back(instrument.Held(held).geometry);
    geometries.back().can_grasp = instrument.Held(held).type == InstrumentType::kGrasper;
  }
  return geometries;
}

// A quarter of the reference's largest displacement, so that errors of a few per cent are visible.
double ErrorScale(const Points& reference) {
  return RoundedUp(reference.rowwise().norm().maxCoeff() / 4);
}

// Refuses organs in contact that overlap at rest by more than the first step may push them apart.
void RefuseOverlaps(const std::vector<OrganModel>& organs) {
  constexpr double kMostOverlap = 1e-4;  // m
  for (const OrganModel& first : organs) {
    for (const OrganContactOptions& contact : first.options().contacts) {
      for (const OrganModel& second : organs) {
        if (second.options().name != contact.with) continue;
        const OrganOverlap overlap = MeasureOverlap(first.rest(), second.rest());
        if (overlap.depth <= kMostOverlap) continue;
        throw InputError(
            Format("[[contact]] of organs \"%s\" and \"%s\": they overlap at the start "
                   "by %.2g mm at [%.3f, %.3f, %.3f]; move one of them apart, or remove "
                   "this contact",
                   first.options().name.c_str(), contact.with.c_str(), 1000 * overlap.depth,
                   overlap.place_W.x(), overlap.place_W.y(), overlap.place_W.z()));
      }
    }
  }
}

}  // namespace

Session::Session(Scene scene, std::vector<DeviceChoice> devices, const Progress& progress)
    : samples(2 * static_cast<std::size_t>(scene.timing.haptic_hz)),
      steps(2 * static_cast<std::size_t>(scene.timing.deformation_hz)),
      external_forces(64),
      frames(2 * static_cast<std::size_t>(std::ceil(scene.timing.render_hz)) + 1),
      scene_(std::move(scene)),
      choices_(std::move(devices)) {
  HPDM_CHECK(choices_.size() == scene_.instruments.size());
  ReadTraces();
  ReadPictures();
  BuildOrgans(progress);
  BuildInstruments();
  WithScenePath(scene_, [&] {
    CompareStiffness(progress);
    BuildWalls();
  });
  const int tools = static_cast<int>(scene_.instruments.size());
  render_scenes =
      std::make_unique<TripleBuffer<SceneSnapshot>>(SizedSnapshot(organs_, tools, true));
  telemetry_scenes =
      std::make_unique<TripleBuffer<SceneSnapshot>>(SizedSnapshot(organs_, tools, false));
}

// Reads the traces first, so that a bad trace is reported before the slow steps.
void Session::ReadTraces() {
  for (const DeviceChoice& choice : choices_) {
    traces_.push_back(choice.type == DeviceChoice::Type::kTrace ? ReadTraceFile(choice.trace)
                                                                : TraceFile());
  }
}

void Session::ReadPictures() {
  if (!scene_.background.empty()) background_ = ReadPng(scene_.background);
  for (const OrganOptions& organ : scene_.organs) {
    textures_.push_back(organ.texture.empty() ? Image() : ReadPng(organ.texture));
  }
}

void Session::BuildOrgans(const Progress& progress) {
  organs_.reserve(scene_.organs.size());
  Eigen::AlignedBox3d around;
  for (OrganOptions& options : scene_.organs) {
    if (progress) {
      progress(Format("organ %s (%zu of %zu)", options.name.c_str(), organs_.size() + 1,
                      scene_.organs.size()));
    }
    SurfaceMesh rest = WithScenePlace(scene_, [&] { return LoadPosedMesh(options, &remarks_); });
    const std::string held = HoldRear(scene_, rest, &options);
    if (!held.empty()) remarks_.push_back(held);
    WithScenePath(scene_, [&] { organs_.emplace_back(options, std::move(rest)); });
    if (!options.texture.empty() && organs_.back().rest().texture_coordinates.rows() == 0) {
      throw InputError(options.mesh + ": has no texture coordinates, but organ \"" + options.name +
                       "\" has a texture; export the mesh with them, or remove organ.texture");
    }
    references_.emplace_back(0, 3);
    const std::vector<std::string>& warnings = organs_.back().warnings();
    remarks_.insert(remarks_.end(), warnings.begin(), warnings.end());
    const Box bounds = AxisAlignedBounds(organs_.back().rest().vertices);
    around.extend(bounds.min);
    around.extend(bounds.max);
  }
  WithScenePath(scene_, [&] { RefuseOverlaps(organs_); });
  LookAtOrgans({around.min(), around.max()}, &scene_.laparoscope);
}

// Refuses a tip that is wider than every organ is long, and jaws that no organ fits between or
// under.
void Session::CheckTip(const InstrumentDescription& held) const {
  const bool jaws = held.type == InstrumentType::kGrasper;
  double widest = 0;
  std::string name;
  for (const OrganModel& organ : organs_) {
    const Points& p = organ.rest().vertices;
    const Vector3d size = p.colwise().maxCoeff() - p.colwise().minCoeff();
    const double across = jaws ? size.minCoeff() : size.maxCoeff();
    if ((jaws && organ.rigid()) || across <= widest) continue;
    widest = across;
    name = organ.options().name;
  }
  const double width = 2 * held.geometry.tip_radius;
  if (name.empty() || width <= widest) return;
  throw InputError(
      Format("instrument \"%s\": its %s %.3g mm wide, wider than organ \"%s\" (%.3g mm); give a "
             "smaller tip_radius",
             held.name.c_str(), jaws ? "jaws are" : "tip is", 1000 * width, name.c_str(),
             1000 * widest),
      {"instrument", held.name, "tip_radius"});
}

void Session::BuildInstruments() {
  for (const InstrumentOptions& instrument : scene_.instruments) {
    for (const OrganModel& organ : organs_) {
      if (instrument.reaction == ReactionType::kPaper || organ.lattice_organ() != nullptr ||
          organ.rigid())
        continue;
      remarks_.push_back(
          "instrument \"" + instrument.name + "\": organ \"" + organ.options().name +
          "\" has no lattice that gives a force; its force is that of the default springs of "
          "reaction = \"paper\"");
    }
    std::vector<InstrumentMeshes>& meshes = instrument_meshes_.emplace_back();
    for (int held = 0; held < instrument.HeldCount(); ++held) {
      WithScenePath(scene_, [&] { CheckTip(instrument.Held(held)); });
      meshes.push_back(LoadInstrumentMeshes(instrument.Held(held)));
    }
    const HandSite site = WithScenePath(scene_, [&] { return SiteOf(instrument); });
    WithScenePath(scene_, [&] {
      kinematics_.emplace_back(instrument.p_trocar_W, site.p_target_W - instrument.p_trocar_W,
                               instrument.device);
    });
    const std::size_t index = kinematics_.size() - 1;
    if (choices_[index].type == DeviceChoice::Type::kSim &&
        !kinematics_.back().Inverse(site.p_target_W, 0, 1).reachable) {
      const double distance = (site.p_target_W - instrument.p_trocar_W).norm();
      remarks_.push_back(
          "instrument \"" + instrument.name + "\"" +
          Format(": the hand's target is %.0f mm from the trocar, but the shaft reaches %.0f to "
                 "%.0f mm; move the trocar or the target",
                 1000 * distance, 1000 * instrument.device.min_insertion,
                 1000 * instrument.device.max_insertion));
    }
    devices_.push_back(WithScenePath(scene_, [&] { return BuildDevice(index, site); }));
  }
  for (const DeviceChoice& choice : choices_) {
    if (choice.type != DeviceChoice::Type::kTrace) trace_length_ = 0;
  }
}

std::unique_ptr<Device> Session::BuildDevice(std::size_t instrument, const HandSite& site) {
  const InstrumentOptions& options = scene_.instruments[instrument];
  switch (choices_[instrument].type) {
    case DeviceChoice::Type::kTrace:
      return BuildTraceDevice(instrument, site);
    case DeviceChoice::Type::kLcm: {
      auto device = std::make_unique<ExternalDevice>(kinematics_[instrument].limits());
      external_readings[instrument] = &device->readings();
      return device;
    }
    case DeviceChoice::Type::kMouse: {
      // Starts on the line to the target, at most halfway, where nothing is touched yet.
      const Vector3d out_W = site.p_trocar_W - site.p_target_W;
      const double distance = std::min(kMouseStart, 0.5 * out_W.norm());
      const HandTarget start = {site.p_target_W + distance * out_W.normalized()};
      auto hand = std::make_unique<MouseHand>(start, options.hand.stiffness, options.hand.damping);
      hand_targets[instrument] = &hand->targets();
      return std::make_unique<SimDevice>(options.device, kinematics_[instrument], std::move(hand));
    }
    case DeviceChoice::Type::kSim:
      break;
  }
  return std::make_unique<SimDevice>(options.device, kinematics_[instrument],
                                     std::make_unique<SimulatedHand>(options.hand, site));
}

std::unique_ptr<Device> Session::BuildTraceDevice(std::size_t instrument, const HandSite& site) {
  const InstrumentOptions& options = scene_.instruments[instrument];
  const TraceFile& file = traces_[instrument];
  const TraceMotion motion(file.rows);
  RefuseWrongScale(file, motion, options.trace.scale);
  TraceMapping mapping{.scale = options.trace.scale,
                       .R_WF = options.trace.R_WF,
                       .position_W = options.trace.position.value_or(Vector3d::Zero()),
                       .speed = options.trace.speed};
  if (!options.trace.position) {
    mapping = Fitted(mapping, motion, site.p_target_W - options.hand.depth * site.normal_W,
                     site.normal_W);
  }
  auto device = std::make_unique<TraceDevice>(file, motion, mapping, kinematics_[instrument]);
  trace_length_ = std::max(trace_length_, device->duration());
  remarks_.push_back("instrument \"" + options.name +
                     "\": " + TraceRemark(file, motion, mapping, *device, !options.trace.position));
  return device;
}

bool Session::HasExternalDevice() const {
  return std::any_of(external_readings.begin(), external_readings.end(),
                     [](const auto* readings) { return readings != nullptr; });
}

void Session::CompareStiffness(const Progress& progress) {
  const double period = ToSeconds(haptic_period_ns());
  for (std::size_t i = 0; i < kinematics_.size(); ++i) {
    const InstrumentOptions& instrument = scene_.instruments[i];
    if (progress) progress("instrument " + instrument.name);
    if (const std::string remark = TrocarRemark(instrument, period); !remark.empty()) {
      remarks_.push_back(remark);
    }
    for (const OrganModel& organ : organs_) {
      if (organ.rigid()) continue;
      const auto stiffest =
          FindStiffestContact(organ, instrument, kinematics_[i], period, instrument.device.delay);
      if (!stiffest) continue;
      contacts_.push_back({instrument.name, organ.options().name, *stiffest});
      for (const std::string& remark :
           {StiffnessRemark(instrument.name, organ.options().name, *stiffest),
            FaintRemark(instrument.name, organ.options().name, *stiffest)}) {
        if (!remark.empty()) remarks_.push_back(remark);
      }
    }
  }
}

void Session::BuildWalls() {
  if (std::none_of(organs_.begin(), organs_.end(),
                   [](const OrganModel& organ) { return organ.rigid(); })) {
    return;
  }
  for (std::size_t i = 0; i < kinematics_.size(); ++i) {
    const InstrumentOptions& instrument = scene_.instruments[i];
    walls_.push_back(
        FindVirtualWall(organs_, instrument, kinematics_[i], ToSeconds(haptic_period_ns())));
    const std::vector<std::string> remarks = WallRemarks(organs_, instrument.name, walls_.back());
    remarks_.insert(remarks_.end(), remarks.begin(), remarks.end());
    if (choices_[i].type == DeviceChoice::Type::kLcm && instrument.device.delay == 0) {
      remarks_.push_back(
          "instrument \"" + instrument.name +
          "\": the stiffness of rigid organs is for a device without delay; give the "
          "driver's delay as instrument.device.delay");
    }
  }
}

HandSite Session::SiteOf(const InstrumentOptions& instrument) const {
  for (const OrganModel& organ : organs_) {
    if (organ.options().name != instrument.hand.organ) continue;
    return SiteOnOrgan(instrument, organ.rest(), organ.centre_of_volume_W());
  }
  throw InputError("instrument \"" + instrument.name + "\": unknown organ \"" +
                   instrument.hand.organ + "\" in instrument.hand; give one of the scene's organs");
}

void Session::EnableForces(bool on) {
  for (const std::unique_ptr<Device>& device : devices_) {
    if (on) device->Home();
    device->EnableForce(on);
  }
}

std::vector<HapticInstrument> Session::HapticInstruments() const {
  std::vector<HapticInstrument> instruments;
  for (std::size_t i = 0; i < devices_.size(); ++i) {
    const InstrumentOptions& options = scene_.instruments[i];
    ForceGuardOptions guard;
    guard.max_force = options.device.max_force;
    guard.max_torque = options.device.max_torque;
    guard.max_force_rate = options.device.max_force_rate;
    guard.stale_age_ns = 4 * kNanosecondsPerSecond / scene_.timing.deformation_hz;
    instruments.push_back({devices_[i].get(),
                           kinematics_[i],
                           GeometriesOf(options),
                           guard,
                           PassivityOf(options.device, ToSeconds(haptic_period_ns())),
                           {options.trocar_friction, options.trocar_torque, options.device.delay}});
  }
  return instruments;
}

std::vector<ToolOptions> Session::DeformationTools() const {
  std::vector<ToolOptions> tools;
  for (std::size_t i = 0; i < scene_.instruments.size(); ++i) {
    const InstrumentOptions& options = scene_.instruments[i];
    tools.push_back({.geometries = GeometriesOf(options),
                     .prefetch = 1.5 / scene_.timing.deformation_hz,
                     .reaction = options.reaction,
                     .k1 = options.k1,
                     .k2 = options.k2});
    if (!walls_.empty()) tools.back().walls = walls_[i].fields;
  }
  return tools;
}

void Session::LoadReference(const std::string& argument) {
  const auto named = std::find_if(organs_.begin(), organs_.end(), [&](const OrganModel& organ) {
    return argument.starts_with(organ.options().name + "=");
  });
  if (named == organs_.end() && organs_.size() != 1) {
    throw InputError("--reference " + argument + ": the scene has " +
                     std::to_string(organs_.size()) + " organs; name one, as in " +
                     organs_[0].options().name + "=FILE");
  }
  const auto organ = static_cast<std::size_t>(named == organs_.end() ? 0 : named - organs_.begin());
  const std::string file =
      named == organs_.end() ? argument : argument.substr(named->options().name.size() + 1);
  references_[organ] = ReadReferenceDisplacements(file, organs_[organ].rest());
  remarks_.push_back(Format("organ \"%s\": error overlay from 0 to %g mm against %s",
                            organs_[organ].options().name.c_str(),
                            1000 * ErrorScale(references_[organ]), file.c_str()));
}

std::vector<OrganVisual> Session::OrganVisuals() const {
  std::vector<OrganVisual> visuals;
  for (std::size_t i = 0; i < organs_.size(); ++i) {
    OrganVisual& visual = visuals.emplace_back();
    visual.rest = &organs_[i].rest();
    visual.model = &organs_[i];
    if (textures_[i].width > 0) visual.texture = &textures_[i];
    if (references_[i].rows() > 0) {
      visual.reference = &references_[i];
      visual.error_scale = ErrorScale(references_[i]);
    }
  }
  return visuals;
}

const Image* Session::Background() const { return background_.width > 0 ? &background_ : nullptr; }

std::vector<InstrumentVisual> Session::InstrumentVisuals() const {
  std::vector<InstrumentVisual> visuals;
  for (std::size_t i = 0; i < scene_.instruments.size(); ++i) {
    const InstrumentOptions& instrument = scene_.instruments[i];
    InstrumentVisual& visual =
        visuals.emplace_back(VisualOf(instrument, instrument_meshes_[i].front()));
    for (int held = 1; held < instrument.HeldCount(); ++held) {
      visual.exchanges.push_back(VisualOf(instrument.Held(held), instrument_meshes_[i][held]));
    }
  }
  return visuals;
}

std::vector<TrainerInput::Instrument> Session::TrainerInstruments() const {
  std::vector<TrainerInput::Instrument> instruments(scene_.instruments.size());
  for (std::size_t i = 0; i < instruments.size(); ++i) {
    instruments[i].exchanges = scene_.instruments[i].HeldCount();
    if (hand_targets[i] == nullptr) continue;
    instruments[i].mouse = kinematics_[i];
    instruments[i].start = hand_targets[i]->Front();
  }
  return instruments;
}

StatusNames Session::Names() const {
  StatusNames names;
  for (const OrganModel& organ : organs_) names.organs.push_back(organ.options().name);
  for (const InstrumentOptions& options : scene_.instruments) {
    names.trocars_W.push_back(options.p_trocar_W);
    std::vector<std::string>& held = names.instruments.emplace_back();
    for (int e = 0; e < options.HeldCount(); ++e) held.push_back(options.Held(e).name);
  }
  return names;
}

SessionInfo Session::Info() const {
  SessionInfo info;
  for (const InstrumentOptions& options : scene_.instruments) {
    info.instruments.push_back(options.name);
    std::vector<std::string>& names = info.held.emplace_back();
    for (int held = 0; held < options.HeldCount(); ++held) names.push_back(options.Held(held).name);
  }
  for (const OrganModel& organ : organs_) {
    info.organs.push_back(
        {organ.options().name, organ.rest().vertices, organ.rest().triangles, std::nullopt});
    if (organ.lattice_organ() == nullptr || organ.HasSplitFunctions()) continue;
    const Lattice& lattice = organ.lattice_organ()->lattice();
    const TensorBasis& basis = lattice.basis();
    LatticeDescription description;
    description.basis = basis.axis(0).type();
    for (int d = 0; d < 3; ++d) {
      description.degree[d] = basis.axis(d).degree();
      description.cells[d] = basis.axis(d).cells();
    }
    description.origin_W = lattice.box().origin_W;
    description.axes = lattice.box().axes;
    description.lengths = lattice.box().lengths;
    description.kept = lattice.kept();
    if (organ.refinement_basis() != nullptr) {
      description.local_refinement = organ.options().lattice.local.refinement;
    }
    info.organs.back().lattice = description;
  }
  return info;
}

}  // namespace hpdm
