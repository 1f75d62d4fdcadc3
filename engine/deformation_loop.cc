#include "engine/deformation_loop.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "engine/base/check.h"
#include "engine/checkpoints.h"
#include "engine/step/present_compliances.h"

namespace hpdm {
namespace {

// m: smoke within it of a suction tube's tip is taken.
constexpr double kSuctionReach = 0.025;

bool IsFinite(const ToolPose& tool) {
  return tool.X_WT.matrix().allFinite() && tool.X_TC.matrix().allFinite() &&
         tool.p_trocar_W.allFinite() && tool.v_tip_W.allFinite() && std::isfinite(tool.jaw);
}

}  // namespace

void DeformationLoop::Step(const ToolState& given, Nanoseconds now_ns, Nanoseconds wake_late_ns) {
  const Nanoseconds started = stopwatch_ ? stopwatch_() : 0;
  // A contact that the first step finds may have lasted for long: assume a second.
  const double dt = record_.number > 0 ? ToSeconds(now_ns - record_.time_ns) : 1;
  ++record_.number;
  record_.input_tick = given.tick;
  record_.time_ns = now_ns;
  record_.wake_late_ns = wake_late_ns;
  record_.device_time_ns = given.device_time_ns;
  record_.flags = kStepOk;

  FollowExercise(given.restart);
  const ToolState& tools = SanitisedTools(given);
  jaw_closings_.Follow(tools.tools, tools.tool_count);
  sample_.duct_actions = duct_actions_.Apply(&tools_, jaw_closings_, joint_relaxation_.links());
  sample_.near_ducts = duct_actions_.NearHooks(tools, joint_relaxation_.links());
  ChooseQuality();
  Collide(tools);
  sample_.layer_work =
      layer_actions_.Apply(tools, jaw_closings_, dt, organs_, joint_relaxation_.links());
  wall_actions_.Apply(tools, jaw_closings_, dt, sample_.contacts, sample_.layer_work, &organs_);
  MoveSmoke(tools);
  Deform(dt);
  BuildContactPatch(tools);
  record_.compute_ns = stopwatch_ ? stopwatch_() - started : 0;
  ObserveLoad();
  Publish(tools);
}

void DeformationLoop::ApplyRecorded(const StepSample& recorded) {
  recorded_count_ = std::min(ToSize(recorded.organ_count), organs_.size());
  recorded_ = recorded.organs;
  shedding_.ApplyRecorded(recorded.step.shed_level);
  if (edges_->checkpoints != nullptr) edges_->checkpoints->ApplyRecorded(recorded.step.kept_step);
}

void DeformationLoop::FollowExercise(const RestartRequest& request) {
  if (edges_->checkpoints == nullptr) return;
  const Checkpoints::Change change = edges_->checkpoints->Follow(request, this);
  record_.kept_step = change.kept;
  record_.restarted_step = change.restarted;
}

// The jaws' closings, the load and the tools belong to the hands and to this machine: they continue.
void DeformationLoop::ReturnTo(const DeformationLoop& kept) {
  organs_ = kept.organs_;
  trackers_ = kept.trackers_;
  organ_contacts_ = kept.organ_contacts_;
  joint_relaxation_ = kept.joint_relaxation_;
  layer_actions_ = kept.layer_actions_;
  duct_actions_ = kept.duct_actions_;
  wall_actions_ = kept.wall_actions_;
  for (OrganStep& organ : organs_) organ.Rebind();
  for (ToolTracker& tracker : trackers_) tracker.LetGo();
  duct_actions_.LetGo(joint_relaxation_.links());
  sample_.contacts.fill({});
  sample_.beside.fill({});
}

// Sets each organ's quality for this step from the state after the last one.
void DeformationLoop::ChooseQuality() {
  for (std::size_t o = 0; o < recorded_count_; ++o) organs_[o].ApplyRecorded(recorded_[o]);
  recorded_count_ = 0;
  const QualityCeiling ceiling = shedding_.Ceiling();
  record_.shed_level = shedding_.level();
  if (record_.shed_level > 0) record_.flags |= kStepShed;
  for (OrganStep& organ : organs_) organ.ChooseQuality(ceiling);
}

void DeformationLoop::ObserveLoad() {
  bool touched = false, settled = true;
  for (const OrganStep& organ : organs_) {
    touched = touched || organ.state().contacts.size() > 0;
    settled = settled && organ.QualitySettled();
  }
  if (stopwatch_ && touched) shedding_.Observe(record_.time_ns, record_.compute_ns, settled);
}

const ToolState& DeformationLoop::NewestTools() {
  edges_->tools.Update();
  return edges_->tools.Front();
}

// Values that are not finite would persist in a tip's last position and in its grasp.
const ToolState& DeformationLoop::SanitisedTools(const ToolState& given) {
  const std::array<ToolPose, kMaxInstruments> last = tools_.tools;
  tools_ = given;
  for (int t = 0; t < kMaxInstruments; ++t) {
    if (t < given.tool_count && IsFinite(given.tools[t])) continue;
    tools_.tools[t] = last[t];
    tools_.contact_points[t] = {};
    if (t < given.tool_count) record_.flags |= kStepNotFinite;
  }
  return tools_;
}

void DeformationLoop::Collide(const ToolState& tools) {
  for (OrganStep& organ : organs_) organ.Begin(tools.time_ns);
  const PresentCompliances compliances(links(), &attached_work_, &organs_);  // for closing jaws
  // No tool has a pose before the haptic loop's first tick.
  HPDM_CHECK(tools.tool_count <= static_cast<int>(trackers_.size()));
  for (int t = 0; t < tools.tool_count; ++t) {
    trackers_[t].Track(tools.tools[t], tools.contact_points[t], &organs_);
  }
  Refine(tools.tool_count);
  for (int t = 0; t < tools.tool_count; ++t) {
    if (!trackers_[t].AddContacts(tools.tools[t], &organs_)) {
      record_.flags |= kStepContactsDropped;
    }
  }
  for (int t = 0; t < tools.tool_count; ++t) {
    if (!trackers_[t].AddShaftContacts(tools.tools[t], &organs_)) {
      record_.flags |= kStepContactsDropped;
    }
  }
  if (!organ_contacts_.AddRows(&organs_)) record_.flags |= kStepContactsDropped;
}

// True if the tool's pedal is pressed and makes it act so.
bool DeformationLoop::Acts(std::size_t tool, const ToolPose& pose, ToolAction action) const {
  return pose.pedal && actions_[tool][ToSize(pose.instrument_index)] == action;
}

// Adds smoke where an energised hook heats a layer, or pressed an organ in the last step. Suction takes it.
void DeformationLoop::MoveSmoke(const ToolState& tools) {
  for (std::size_t t = 0; t < ToSize(tools.tool_count); ++t) {
    const ToolPose& pose = tools.tools[t];
    const bool heats = sample_.layer_work[t].burning > 0 ||
                       sample_.contacts[t].force_on_tissue_W.squaredNorm() > 0;
    if (heats && Acts(t, pose, ToolAction::kBurn)) {
      smoke_.Add({.p_W = pose.X_WT.translation(), .time_ns = record_.time_ns});
    }
  }
  for (std::size_t t = 0; t < ToSize(tools.tool_count); ++t) {
    const ToolPose& pose = tools.tools[t];
    if (Acts(t, pose, ToolAction::kSuck)) smoke_.Take(pose.X_WT.translation(), kSuctionReach);
  }
}

// Places the local functions where the tips are, or are about to be.
void DeformationLoop::Refine(int tool_count) {
  for (std::size_t o = 0; o < organs_.size(); ++o) {
    std::array<Vector3d, kMaxInstruments> points;
    std::size_t count = 0;
    for (int t = 0; t < tool_count; ++t) {
      const std::optional<Vector3d> point =
          trackers_[t].RestPointOn(static_cast<int>(o), organs_[o].model());
      if (point) points[count++] = *point;
    }
    organs_[o].Refine(std::span(points.data(), count), record_.number);
  }
}

// Stages A to C, `dt` (s) after the last step.
void DeformationLoop::Deform(double dt) {
  record_.iterations = 0;
  record_.residual = 0;
  for (OrganStep& organ : organs_) {
    organ.Leak(ToSeconds(record_.time_ns), dt);
    organ.Wake();
    organ.RepositionControlPoints();
  }
  joint_relaxation_.Relax(dt, organ_contacts_.contacts(), &organs_, &record_);
  organ_contacts_.Remember();
  LetGo();
  for (OrganStep& organ : organs_) organ.RelocateVertices(record_.number);
}

// Organs that no layer holds any more touch what they hung on.
void DeformationLoop::LetGo() {
  for (const AttachmentLink& link : links()) {
    for (std::size_t m = 0; m < link.joint().members().size(); ++m) {
      const int organ = link.joint().members()[m].organ;
      if (!link.HasLetGo(m) || !organs_[ToSize(organ)].state().attached) continue;
      organs_[ToSize(organ)].state().attached = false;
      organ_contacts_.Begin(organ);
    }
  }
}

// Stage D: builds the surface patches for the haptic loop until the next step.
void DeformationLoop::BuildContactPatch(const ToolState& tools) {
  for (OrganStep& organ : organs_) organ.state().tips.Clear();
  for (int t = 0; t < tools.tool_count; ++t) trackers_[t].AddTips(&organs_);
  for (int t = 0; t < tools.tool_count; ++t) trackers_[t].AddShaftTips(&organs_);
  const PresentCompliances compliances(links(), &attached_work_, &organs_);
  for (std::size_t o = 0; o < organs_.size(); ++o) {
    OrganState& state = organs_[o].state();
    if (state.present_compliance == nullptr || state.tips.size() == 0) continue;
    const LatticeCompliance& free = *state.present_compliance;
    const JointRelaxation::Hold& held = joint_relaxation_.HoldOn(o);
    // A rejected step has removed its rows.
    const bool has_rows = state.contacts.size() > 0;
    if (!has_rows || held.hold == nullptr || held.hold->size() == 0) {
      state.tips.Condense(free);
    } else {
      state.tips.Condense(HeldCompliance(free, state.contacts, *held.hold, held.body, &loads_));
    }
  }
  ContactPatch& patch = edges_->patch.Back();
  patch.tool_count = tools.tool_count;
  for (int t = 0; t < tools.tool_count; ++t) {
    trackers_[t].FillPatches(tools.tools[t], &organs_, &patch.tools[t]);
    duct_actions_.FillPatch(t, tools.tools[t], joint_relaxation_.links(), organs_, &patch.tools[t]);
    for (ToolPatch& place : patch.tools[t].places) place.time_ns = tools.time_ns;
  }
}

void DeformationLoop::FillSample(const ToolState& tools) {
  sample_.step = record_;
  sample_.organ_count = static_cast<int>(organs_.size());
  for (std::size_t o = 0; o < organs_.size(); ++o) sample_.organs[o] = organs_[o].Outcome();
  for (const AttachmentLink& link : links()) {
    for (std::size_t l = 0; l < link.joint().layers().size(); ++l) {
      const int index = link.joint().layers()[l].bed.index;
      sample_.attachments[ToSize(index)] = link.outcomes()[l];
      sample_.attachment_count = std::max(sample_.attachment_count, index + 1);
    }
    for (const DuctState& duct : link.state().ducts()) {
      sample_.ducts[ToSize(duct.model().index)] = duct.Outcome();
      sample_.duct_count = std::max(sample_.duct_count, duct.model().index + 1);
    }
  }
  FillTensions();
  FillLumens();
  sample_.tool_count = tools.tool_count;
  sample_.tools = tools.tools;
  for (int t = 0; t < tools.tool_count; ++t) {
    const ToolPatches& patches = edges_->patch.Back().tools[t];
    // A held duct is no contact with the organ that holds its end.
    sample_.contacts[t] = duct_actions_.FillsPatch(t) ? SolvedContact() : InWorld(patches.main());
    std::size_t beside = 0;
    for (std::size_t p = 0; p < kMaxPlaces; ++p) {
      if (static_cast<int>(p) == patches.main_place) continue;
      sample_.beside[t][beside++] = InWorld(patches.places[p]);
    }
  }
}

// An organ whose shape has not changed keeps its tensions.
void DeformationLoop::FillTensions() {
  std::size_t first = 0;
  for (const OrganStep& organ : organs_) {
    const LatticeOrgan* lattice = organ.model().lattice_organ();
    if (lattice == nullptr) continue;
    const LayerTensions& tensions = lattice->fillings_and_layers().tensions();
    HPDM_CHECK(first + tensions.layers() <= kMaxLayers);
    if (organ.state().version == record_.number && tensions.layers() > 0) {
      tensions.FindLargest(organ.state().vertices, organ.state().relaxation->Rotation(),
                           {sample_.layer_tensions.data() + first, tensions.layers()});
    }
    first += tensions.layers();
  }
  sample_.layer_count = static_cast<int>(first);
}

void DeformationLoop::FillLumens() {
  std::size_t count = 0;
  for (const OrganStep& organ : organs_) {
    for (const LumenOutcome& lumen : organ.state().leaks.outcomes()) {
      if (count < sample_.lumens.size()) sample_.lumens[count++] = lumen;
    }
  }
  sample_.lumen_count = static_cast<int>(count);
}

// Adds the organ's offset to a contact.
SolvedContact DeformationLoop::InWorld(SolvedContact contact) const {
  if (contact.organ < 0) return contact;
  const Vector3d& offset_W = organs_[contact.organ].state().offset_W;
  contact.contact_W += offset_W;
  const bool has_original =
      contact.reaction == ReactionType::kLattice || contact.kind == ContactKind::kGrasp;
  if (has_original) contact.p_original_W += offset_W;
  return contact;
}

// Publishes the haptic loop's patch first, so the copies for display do not delay it.
void DeformationLoop::Publish(const ToolState& tools) {
  edges_->patch.Back().step = record_;
  FillSample(tools);
  edges_->patch.Publish();
  if (edges_->steps != nullptr) edges_->steps->Push(sample_);
  for (TripleBuffer<SceneSnapshot>* edge : {&edges_->render, &edges_->telemetry}) {
    if (edge->Back().organs.empty()) continue;
    FillScene(tools, &edge->Back());
    edge->Publish();
  }
}

void DeformationLoop::FillScene(const ToolState& tools, SceneSnapshot* scene) const {
  scene->step = record_;
  scene->tool_count = tools.tool_count;
  scene->tools = tools.tools;
  scene->contacts = sample_.contacts;
  scene->beside = sample_.beside;
  scene->smoke = smoke_;
  for (std::size_t t = 0; t < ToSize(tools.tool_count); ++t) {
    scene->burns[t] = Acts(t, tools.tools[t], ToolAction::kBurn);
    scene->sucks[t] = Acts(t, tools.tools[t], ToolAction::kSuck);
    scene->readouts[t].layer = layer_actions_.InReach(static_cast<int>(t));
    duct_actions_.FillReadout(static_cast<int>(t), &scene->readouts[t]);
  }
  for (std::size_t o = 0; o < organs_.size(); ++o) organs_[o].FillSnapshot(&scene->organs[o]);
  for (const AttachmentLink& link : links()) {
    for (const DuctState& duct : link.state().ducts()) {
      const auto index = ToSize(duct.model().index);
      if (index < scene->ducts.size()) duct.FillSnapshot(&scene->ducts[index]);
    }
    if (scene->damage.empty()) continue;
    for (std::size_t l = 0; l < link.joint().layers().size(); ++l) {
      const std::size_t index = ToSize(link.joint().layers()[l].bed.index);
      std::ranges::copy(link.state().DamageOf(l), scene->damage[index].begin());
      std::ranges::copy(link.state().BurntOf(l), scene->burnt[index].begin());
    }
  }
}

SceneSnapshot SizedSnapshot(const std::vector<OrganModel>& organs, int tool_count,
                            bool with_vertices, std::span<const AttachmentBed> beds,
                            std::span<const DuctModel> ducts) {
  SceneSnapshot scene;
  for (const AttachmentBed& bed : beds) scene.damage.emplace_back(ToSize(bed.size()), 0.0f);
  scene.burnt = scene.damage;
  for (const DuctModel& duct : ducts) {
    scene.ducts.emplace_back(SnapshotOf(duct.rod));
  }
  scene.tool_count = tool_count;
  for (const OrganModel& model : organs) {
    OrganSnapshot organ;
    const bool of_vertices = !with_vertices && model.HasSplitFunctions();
    const int slots = of_vertices ? 0 : model.RefinementSlots(tool_count);
    organ.control_displacements =
        Points::Zero(of_vertices ? model.rest().vertices.rows() : model.control_points(), 3);
    organ.local_functions.assign(slots, -1);
    organ.local_displacements = Points::Zero(slots, 3);
    if (with_vertices) organ.vertices = model.rest().vertices.cast<float>();
    scene.organs.push_back(std::move(organ));
  }
  return scene;
}

}  // namespace hpdm
