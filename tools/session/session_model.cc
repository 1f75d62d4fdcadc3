#include "tools/session/session_model.h"

#include <algorithm>
#include <utility>

#include "engine/attachment/borne_weight.h"
#include "engine/base/check.h"
#include "engine/base/error.h"
#include "engine/pairs/organ_overlap.h"
#include "engine/tissue/support.h"
#include "lcmtypes/telemetry/exercise_events.h"
#include "tools/session/hand_site.h"
#include "tools/session/instrument_meshes.h"
#include "tools/session/scene_defaults.h"
#include "tools/session/session_scene.h"
#include "tools/shared/report_text.h"
#include "tools/shared/with_scene_path.h"

namespace hpdm {
namespace {

std::vector<ToolGeometry> GeometriesOf(const InstrumentOptions& instrument) {
  std::vector<ToolGeometry> geometries;
  for (int held = 0; held < instrument.HeldCount(); ++held) {
    geometries.push_back(instrument.Held(held).geometry);
    ToolGeometry& geometry = geometries.back();
    const InstrumentType type = instrument.Held(held).type;
    const JawOptions& jaws = instrument.Held(held).jaws;
    if (!jaws.meshes.empty()) geometry.opening = jaws.opening;
    geometry.can_grasp = type == InstrumentType::kGrasper;
    if (type == InstrumentType::kHook) geometry.action = ToolAction::kBurn;
    if (type == InstrumentType::kScissors) geometry.action = ToolAction::kCut;
    if (type == InstrumentType::kClipApplier) geometry.action = ToolAction::kClip;
    if (type == InstrumentType::kSuction) geometry.action = ToolAction::kSuck;
  }
  return geometries;
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

void RefuseCuts(const Scene& scene) {
  for (const OrganOptions& organ : scene.organs) {
    if (organ.cuts.empty()) continue;
    throw InputError(scene.path.string() + ": organ \"" + organ.name +
                     "\": has a [[cut]], which only hpdm solve and hpdm check take; remove it for "
                     "a session");
  }
}

SessionModel::SessionModel(Scene scene, const Progress& progress)
    : scene_(std::move(scene)), pictures_(std::make_shared<Pictures>()) {
  ReadPictures();
  BuildOrgans(progress);
  BuildInstruments();
  WithScenePath(scene_, [&] {
    CompareStiffness(progress);
    BuildWalls();
  });
}

// The remarks on contacts are those of the other model.
SessionModel::SessionModel(const SessionModel& other, std::size_t organ, double young)
    : scene_(other.scene_),
      is_of_scene_file_(false),
      pictures_(other.pictures_),
      organs_(other.organs_),
      beds_(other.beds_),
      ducts_(other.ducts_),
      borne_W_(other.borne_W_),
      sites_(other.sites_),
      kinematics_(other.kinematics_),
      remarks_(other.remarks_),
      contacts_(other.contacts_),
      walls_(other.walls_) {
  HPDM_CHECK(organ < organs_.size());
  // With the support that a scene without one gets.
  OrganOptions options = organs_[organ].options();
  options.material.young = young;
  organs_[organ] = OrganModel(options, organs_[organ].rest());
  scene_.organs[organ].material.young = young;
}

std::shared_ptr<const SessionModel> SessionModel::WithYoung(std::size_t organ, double young) const {
  return std::shared_ptr<const SessionModel>(new SessionModel(*this, organ, young));
}

void SessionModel::ReadPictures() {
  if (!scene_.background.empty()) pictures_->background = ReadPng(scene_.background);
  for (const OrganOptions& organ : scene_.organs) {
    pictures_->textures.push_back(organ.texture.empty() ? Image() : ReadPng(organ.texture));
  }
}

void SessionModel::BuildOrgans(const Progress& progress) {
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
    const std::vector<std::string>& warnings = organs_.back().warnings();
    remarks_.insert(remarks_.end(), warnings.begin(), warnings.end());
    const Box bounds = AxisAlignedBounds(organs_.back().rest().vertices);
    around.extend(bounds.min);
    around.extend(bounds.max);
  }
  WithScenePath(scene_, [&] { RefuseOverlaps(organs_); });
  WithScenePath(scene_, [&] { BuildBeds(); });
  WithScenePath(scene_, [&] { BuildDucts(); });
  LookAtOrgans({around.min(), around.max()}, &scene_.laparoscope);
}

void SessionModel::BuildDucts() {
  const auto named = [&](const std::string& name) -> const OrganModel* {
    const auto found = std::ranges::find(
        organs_, name, [](const OrganModel& organ) { return organ.options().name; });
    return found == organs_.end() ? nullptr : &*found;
  };
  for (const DuctOptions& duct : scene_.ducts) {
    ducts_.emplace_back(duct, named(duct.a), named(duct.b), static_cast<int>(ducts_.size()));
    for (std::size_t other = 0; other + 1 < ducts_.size(); ++other) {
      RefuseSharedEnds(ducts_[other], ducts_.back());
    }
  }
}

void SessionModel::BuildBeds() {
  const auto named = [&](const std::string& name) -> const OrganModel& {
    return *std::find_if(organs_.begin(), organs_.end(),
                         [&](const OrganModel& organ) { return organ.options().name == name; });
  };
  for (const AttachmentOptions& attachment : scene_.attachments) {
    beds_.emplace_back(attachment, named(attachment.a), named(attachment.b),
                       static_cast<int>(beds_.size()));
    for (std::size_t other = 0; other + 1 < beds_.size(); ++other) {
      RefuseSharedSurface(beds_[other], beds_.back());
    }
  }
  borne_W_ = BorneWeight(organs_, beds_);
}

// Refuses a tip that is wider than every organ is long, and jaws that no organ fits between or
// under.
void SessionModel::CheckTip(const InstrumentDescription& held) const {
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

void SessionModel::BuildInstruments() {
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
    std::vector<InstrumentMeshes>& meshes = pictures_->instruments.emplace_back();
    for (int held = 0; held < instrument.HeldCount(); ++held) {
      WithScenePath(scene_, [&] { CheckTip(instrument.Held(held)); });
      meshes.push_back(LoadInstrumentMeshes(instrument.Held(held)));
    }
    sites_.push_back(WithScenePath(scene_, [&] { return SiteOf(instrument); }));
    const HandSite& site = sites_.back();
    WithScenePath(scene_, [&] {
      kinematics_.emplace_back(instrument.p_trocar_W, site.p_target_W - instrument.p_trocar_W,
                               instrument.device);
    });
  }
}

void SessionModel::CompareStiffness(const Progress& progress) {
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
      const std::string& name = organ.options().name;
      // The search does not know of what an attachment adds to a weak spring.
      const bool hangs = organ.options().supports.empty() && IsAttached(scene_.attachments, name);
      for (const std::string& remark :
           {StiffnessRemark(instrument.name, name, *stiffest),
            hangs ? std::string() : FaintRemark(instrument.name, name, *stiffest)}) {
        if (!remark.empty()) remarks_.push_back(remark);
      }
    }
  }
}

void SessionModel::BuildWalls() {
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
  }
}

HandSite SessionModel::SiteOf(const InstrumentOptions& instrument) const {
  for (const OrganModel& organ : organs_) {
    if (organ.options().name != instrument.hand.organ) continue;
    return SiteOnOrgan(instrument, organ.rest(), organ.centre_of_volume_W());
  }
  throw InputError("instrument \"" + instrument.name + "\": unknown organ \"" +
                   instrument.hand.organ + "\" in instrument.hand; give one of the scene's organs");
}

std::vector<HapticInstrument> SessionModel::HapticInstruments(
    const std::vector<std::unique_ptr<Device>>& devices) const {
  std::vector<HapticInstrument> instruments;
  const bool still = OrgansAreStill(scene_);
  for (std::size_t i = 0; i < devices.size(); ++i) {
    const InstrumentOptions& options = scene_.instruments[i];
    PassivityOptions passivity = PassivityOf(options.device, ToSeconds(haptic_period_ns()));
    passivity.still = still;
    ForceGuardOptions guard;
    guard.max_force = options.device.max_force;
    guard.max_torque = options.device.max_torque;
    guard.max_force_rate = options.device.max_force_rate;
    guard.stale_age_ns = 4 * kNanosecondsPerSecond / scene_.timing.deformation_hz;
    instruments.push_back({devices[i].get(),
                           kinematics_[i],
                           GeometriesOf(options),
                           guard,
                           passivity,
                           {options.trocar_friction, options.trocar_torque, options.device.delay}});
  }
  return instruments;
}

std::vector<ToolOptions> SessionModel::DeformationTools() const {
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

std::vector<AttachmentVisual> SessionModel::AttachmentVisuals() const {
  std::vector<AttachmentVisual> visuals;
  for (const AttachmentBed& bed : beds_) {
    AttachmentVisual& visual = visuals.emplace_back();
    visual.bed = &bed;
    for (std::size_t o = 0; o < organs_.size(); ++o) {
      const std::string& name = organs_[o].options().name;
      if (name == bed.options.a) visual.organs[0] = static_cast<int>(o);
      if (name == bed.options.b) visual.organs[1] = static_cast<int>(o);
    }
  }
  return visuals;
}

std::vector<DuctVisual> SessionModel::DuctVisuals() const {
  std::vector<DuctVisual> visuals;
  for (const DuctModel& duct : ducts_) {
    visuals.push_back({.model = &duct, .colour = duct.options.colour.cast<float>()});
  }
  return visuals;
}

std::vector<OrganVisual> SessionModel::OrganVisuals() const {
  std::vector<OrganVisual> visuals;
  for (std::size_t i = 0; i < organs_.size(); ++i) {
    OrganVisual& visual = visuals.emplace_back();
    visual.rest = &organs_[i].rest();
    visual.model = &organs_[i];
    if (pictures_->textures[i].width > 0) visual.texture = &pictures_->textures[i];
  }
  return visuals;
}

const Image* SessionModel::Background() const {
  return pictures_->background.width > 0 ? &pictures_->background : nullptr;
}

std::vector<InstrumentVisual> SessionModel::InstrumentVisuals() const {
  std::vector<InstrumentVisual> visuals;
  for (std::size_t i = 0; i < scene_.instruments.size(); ++i) {
    const InstrumentOptions& instrument = scene_.instruments[i];
    InstrumentVisual& visual =
        visuals.emplace_back(VisualOf(instrument, pictures_->instruments[i].front()));
    for (int held = 1; held < instrument.HeldCount(); ++held) {
      visual.exchanges.push_back(VisualOf(instrument.Held(held), pictures_->instruments[i][held]));
    }
  }
  return visuals;
}

StatusNames SessionModel::Names() const {
  StatusNames names;
  names.exercise = scene_.exercise;
  for (const AttachmentBed& bed : beds_) names.layers.push_back(LabelOf(bed.options));
  for (const DuctOptions& duct : scene_.ducts) {
    names.ducts.push_back(duct.name);
    names.duct_radii.push_back(duct.radius);
  }
  for (const OrganModel& organ : organs_) names.organs.push_back(organ.options().name);
  for (const InstrumentOptions& options : scene_.instruments) {
    names.trocars_W.push_back(options.p_trocar_W);
    std::vector<std::string>& held = names.instruments.emplace_back();
    std::vector<double>& radii = names.tip_radii.emplace_back();
    std::vector<double>& jaws = names.duct_jaws.emplace_back();
    std::vector<bool>& frees = names.frees_layers.emplace_back();
    for (int e = 0; e < options.HeldCount(); ++e) {
      const InstrumentDescription& instrument = options.Held(e);
      held.push_back(instrument.name);
      radii.push_back(instrument.geometry.tip_radius);
    }
    for (const ToolGeometry& geometry : GeometriesOf(options)) {
      const bool closes =
          geometry.action == ToolAction::kClip || geometry.action == ToolAction::kCut;
      jaws.push_back(closes ? geometry.JawsLength() : 0);
      frees.push_back(geometry.action == ToolAction::kBurn || geometry.action == ToolAction::kCut);
    }
  }
  return names;
}

SessionInfo SessionModel::Info() const {
  SessionInfo info;
  info.exercise = scene_.exercise;
  info.left_handed = scene_.left_handed;
  for (const AttachmentBed& bed : beds_) {
    info.attachments.push_back({LabelOf(bed.options), bed.areas.sum()});
  }
  for (const InstrumentOptions& options : scene_.instruments) {
    info.instruments.push_back(options.name);
    std::vector<std::string>& names = info.held.emplace_back();
    for (int held = 0; held < options.HeldCount(); ++held) names.push_back(options.Held(held).name);
  }
  for (const DuctOptions& duct : scene_.ducts) info.ducts.push_back(duct.name);
  for (const OrganModel& organ : organs_) {
    const std::vector<LayerOptions>& layers = organ.options().layers;
    for (std::size_t l = 0; l < layers.size(); ++l) {
      info.layers.push_back({"layer[" + std::to_string(l) + "] of " + organ.options().name,
                             layers[l].strength.value_or(0)});
    }
    if (organ.lattice_organ() != nullptr) {
      const std::size_t lumens = organ.lattice_organ()->fillings_and_layers().lumens().size();
      for (std::size_t l = 0; l < lumens; ++l) {
        info.lumens.push_back(
            LumenName(organ.options().name, lumens > 1 ? static_cast<int>(l) : -1));
      }
    }
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
