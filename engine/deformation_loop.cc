#include "engine/deformation_loop.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "engine/base/check.h"

namespace hpdm {
namespace {

// m. A tool that never had a pose is placed this far from any organ.
constexpr double kFarAway = 1e3;

bool IsFinite(const ToolPose& tool) {
  return tool.X_WT.matrix().allFinite() && tool.p_trocar_W.allFinite() &&
         tool.v_tip_W.allFinite() && std::isfinite(tool.jaw);
}

Sheddable SheddableIn(const std::vector<OrganModel>& organs) {
  std::vector<OrganOptions> options;
  for (const OrganModel& organ : organs) options.push_back(organ.options());
  return SheddableOf(options);
}

// Fills in all of the shape except its vertices.
void FillShape(const OrganModel& model, const OrganState& state, OrganSnapshot* shape) {
  const int n = model.control_points();
  const ActiveRefinement& active = state.contacts.refinement;
  shape->control_displacements = state.control_displacements.topRows(n);
  shape->local_displacements = state.control_displacements.bottomRows(active.slots());
  for (int s = 0; s < active.slots(); ++s) {
    const int function = active.Function(s);
    shape->local_functions[s] =
        function < 0 ? -1 : model.refinement_basis()->finer().kept()[function];
  }
  shape->indentation_count = 0;
  for (int i = 0; i < state.contacts.size(); ++i) {
    const ContactConstraints::Row& row = state.contacts[i];
    const bool indents = row.indentation.radius() < row.indentation.resolved_radius();
    if (!indents || shape->indentation_count == kMaxInstruments) continue;
    shape->indentations[shape->indentation_count++] =
        AppliedIndentation(row.indentation, row.p_rest_W, row.force_W);
  }
}

}  // namespace

DeformationLoop::DeformationLoop(const std::vector<OrganModel>& organs,
                                 const std::vector<ToolOptions>& tools,
                                 const DeformationEdges& edges,
                                 std::function<Nanoseconds()> stopwatch, Nanoseconds budget)
    : models_(organs),
      edges_(edges),
      stopwatch_(std::move(stopwatch)),
      shedding_(SheddableIn(organs), budget) {
  HPDM_CHECK(tools.size() <= kMaxInstruments && organs.size() <= kMaxOrgans);
  states_.reserve(organs.size());
  for (const OrganModel& model : organs)
    states_.emplace_back(model, static_cast<int>(tools.size()), stopwatch_);
  for (std::size_t o = 0; o < organs.size(); ++o) {
    inversion_recoveries_.emplace_back(organs[o], states_[o]);
    blend_controllers_.emplace_back(organs[o].options());
  }
  for (ToolPose& tool : tools_.tools) tool.X_WT.translation().setConstant(kFarAway);
  for (std::size_t t = 0; t < tools.size(); ++t) {
    trackers_.emplace_back(static_cast<int>(t), tools[t]);
  }
}

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

  const ToolState& tools = SanitisedTools(given);
  ChooseQuality();
  Collide(tools);
  WakeTouched();
  RepositionControlPoints();
  Relax(dt);
  RelocateVertices();
  BuildContactPatch(tools);
  record_.compute_ns = stopwatch_ ? stopwatch_() - started : 0;
  ObserveLoad();
  Publish(tools);
}

void DeformationLoop::ApplyRecorded(const StepSample& recorded) {
  const auto organs = std::min(static_cast<std::size_t>(recorded.organ_count), states_.size());
  for (std::size_t o = 0; o < organs; ++o) {
    const OrganRelaxation& organ = recorded.organs[o];
    if (organ.out_of_time) {
      states_[o].relaxation->StopNextAfter(organ.iterations);
      states_[o].awake = true;
    }
    states_[o].quality.finite_strain_blend = organ.finite_strain_blend;
    states_[o].quality.refinement_weight = organ.refinement_weight;
  }
  shedding_.ApplyRecorded(recorded.step.shed_level);
  applies_recorded_ = true;
}

// Sets each organ's quality for this step from the state after the last one.
void DeformationLoop::ChooseQuality() {
  const QualityCeiling ceiling = shedding_.Ceiling();
  record_.shed_level = shedding_.level();
  if (record_.shed_level > 0) record_.flags |= kStepShed;
  for (std::size_t o = 0; o < states_.size(); ++o) {
    OrganState& state = states_[o];
    const StepQuality chosen =
        blend_controllers_[o].Next(ceiling, state.contacts.size() > 0,
                                   inversion_recoveries_[o].gradient(), state.relaxed.share_slope);
    if (applies_recorded_) {
      state.quality.newton_iterations = chosen.newton_iterations;
      blend_controllers_[o].ApplyRecorded(state.quality);
    } else {
      state.quality = chosen;
    }
    state.relaxation->SetQuality(state.quality);
  }
  applies_recorded_ = false;
}

void DeformationLoop::ObserveLoad() {
  bool touched = false, settled = true;
  for (std::size_t o = 0; o < states_.size(); ++o) {
    touched = touched || states_[o].contacts.size() > 0;
    settled = settled && blend_controllers_[o].settled();
  }
  if (stopwatch_ && touched) shedding_.Observe(record_.time_ns, record_.compute_ns, settled);
}

const ToolState& DeformationLoop::NewestTools() {
  edges_.tools.Update();
  return edges_.tools.Front();
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
  for (std::size_t o = 0; o < states_.size(); ++o) {
    OrganState& state = states_[o];
    state.offset_last_W = state.offset_W;
    state.offset_W = models_[o].options().motion.Offset(tools.time_ns);
    if (!state.tree_fits) state.tree.Refit(state.vertices);
    state.tree_fits = true;
    state.contacts.Clear();
  }
  // No tool has a pose before the haptic loop's first tick.
  HPDM_CHECK(tools.tool_count <= static_cast<int>(trackers_.size()));
  for (int t = 0; t < tools.tool_count; ++t) {
    trackers_[t].Track(tools.tools[t], tools.contact_points[t], models_, &states_);
  }
  Refine(tools.tool_count);
  for (int t = 0; t < tools.tool_count; ++t) {
    if (!trackers_[t].AddContacts(tools.tools[t], models_, &states_)) {
      record_.flags |= kStepContactsDropped;
    }
  }
}

// Places the local functions where the tips are, or are about to be.
void DeformationLoop::Refine(int tool_count) {
  for (std::size_t o = 0; o < states_.size(); ++o) {
    const RefinementBasis* basis = models_[o].refinement_basis();
    if (basis == nullptr) continue;
    std::array<Vector3d, kMaxInstruments> points;
    std::size_t count = 0;
    for (int t = 0; t < tool_count; ++t) {
      if (trackers_[t].organ() == static_cast<int>(o)) {
        points[count++] = trackers_[t].RestPoint(models_);
      }
    }
    OrganState& state = states_[o];
    ActiveRefinement& active = state.contacts.refinement;
    if (count == 0 && active.used() == 0) continue;
    active.ChooseNearest(basis->centres(), std::span(points.data(), count),
                         LocalFunctionsOf(models_[o].options()), state.quality.refinement_weight);
    bool changed = false;
    for (int s = 0; s < active.slots(); ++s) {
      const int row = models_[o].control_points() + s;
      state.recovery.ScaleRow(row, active.Kept(s));
      if (!active.Changed(s)) continue;
      state.control_displacements.row(row).setZero();
      inversion_recoveries_[o].ResetRow(row);
      changed = true;
    }
    state.relaxation->SetActiveFunctions(active);
    if (changed) state.version = record_.number;
  }
}

void DeformationLoop::WakeTouched() {
  for (OrganState& state : states_) state.awake = state.awake || state.contacts.size() > 0;
}

// True if an untouched next step would leave the organ unchanged. A scan of the inversion detector
// in progress must end first.
bool DeformationLoop::AtRest(std::size_t organ) const {
  const OrganState& state = states_[organ];
  return state.contacts.size() == 0 && state.control_displacements.isZero(0) &&
         state.recovery.AtRest() && state.relaxation->AtRest() &&
         !inversion_recoveries_[organ].inverted();
}

// Stage A (Eq. 26-28): moves the contacts to their targets by the least change of the lattice.
void DeformationLoop::RepositionControlPoints() {
  for (OrganState& state : states_) {
    if (!state.awake) continue;
    Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor, kMaxContacts, 3> change(
        state.contacts.size(), 3);
    for (int i = 0; i < state.contacts.size(); ++i) {
      const ContactConstraints::Row& row = state.contacts[i];
      const Vector3d p =
          row.p_rest_W +
          (state.contacts.Weights().row(i) * state.control_displacements).transpose();
      Vector3d move = row.target_W - p;
      if (row.kind == ContactConstraints::RowKind::kPress) {
        move = std::min(0.0, row.normal_W.dot(move)) * row.normal_W;
      }
      change.row(i) = move;
    }
    MoveDirectly(state.contacts.Weights(), change, state.control_displacements);
  }
}

// Stage B: minimises the energy under the contacts, `dt` (s) after the last step.
void DeformationLoop::Relax(double dt) {
  record_.iterations = 0;
  record_.residual = 0;
  for (std::size_t o = 0; o < states_.size(); ++o) {
    OrganState& state = states_[o];
    if (!state.awake) continue;
    InversionRecovery& inversion_recovery = inversion_recoveries_[o];
    state.relaxed = inversion_recovery.Relax(dt, &state);
    if (!state.control_displacements.allFinite()) {
      state.control_displacements.setZero();
      state.contacts.Clear();
    }
    if (inversion_recovery.not_finite()) record_.flags |= kStepNotFinite;
    if (inversion_recovery.inverted()) record_.flags |= kStepInverted;
    if (inversion_recovery.recovering()) record_.flags |= kStepRecovering;
    if (!state.relaxed.converged) record_.flags |= kStepBudgetSpent;
    if (state.relaxed.regularised) record_.flags |= kStepContactsRegularised;
    record_.iterations += state.relaxed.iterations;
    record_.residual = std::max(record_.residual, state.relaxed.residual);
  }
}

// Stage C (Eq. 4): x = X + B U. An organ at rest then falls asleep.
void DeformationLoop::RelocateVertices() {
  for (std::size_t o = 0; o < states_.size(); ++o) {
    OrganState& state = states_[o];
    if (!state.awake) continue;
    state.awake = !AtRest(o);
    if (models_[o].rigid()) continue;
    models_[o].relocation().Relocate(state.control_displacements, &state.vertices);
    models_[o].AddLocalDisplacements(state.contacts.refinement, state.control_displacements,
                                     &state.vertices);
    state.tree_fits = false;
    state.version = record_.number;
  }
}

// Stage D: builds the surface patches for the haptic loop until the next step.
void DeformationLoop::BuildContactPatch(const ToolState& tools) {
  for (OrganState& state : states_) state.tips.Clear();
  for (int t = 0; t < tools.tool_count; ++t) trackers_[t].AddTip(models_, &states_);
  for (OrganState& state : states_) {
    if (state.tips.size() > 0) state.tips.Condense(*state.relaxation->compliance());
  }
  ContactPatch& patch = edges_.patch.Back();
  patch.tool_count = tools.tool_count;
  for (int t = 0; t < tools.tool_count; ++t) {
    trackers_[t].FillPatch(tools.tools[t], models_, &states_, &patch.tools[t]);
  }
}

void DeformationLoop::FillSample(const ToolState& tools) {
  sample_.step = record_;
  sample_.organ_count = static_cast<int>(states_.size());
  for (std::size_t o = 0; o < states_.size(); ++o) {
    sample_.organs[o] = {
        states_[o].relaxed.iterations,          states_[o].relaxed.out_of_time,
        inversion_recoveries_[o].inverted(),    inversion_recoveries_[o].recovering(),
        states_[o].quality.finite_strain_blend, states_[o].quality.refinement_weight};
  }
  sample_.tool_count = tools.tool_count;
  sample_.tools = tools.tools;
  for (int t = 0; t < tools.tool_count; ++t) {
    SolvedContact& contact = sample_.contacts[t];
    contact = edges_.patch.Back().tools[t];
    if (contact.organ < 0) continue;
    const Vector3d& offset_W = states_[contact.organ].offset_W;
    contact.contact_W += offset_W;
    const bool has_original =
        contact.reaction == ReactionType::kLattice || contact.kind == ContactKind::kGrasp;
    if (has_original) contact.p_original_W += offset_W;
  }
}

// Publishes the haptic loop's patch first, so the copies for display do not delay it.
void DeformationLoop::Publish(const ToolState& tools) {
  edges_.patch.Back().step = record_;
  FillSample(tools);
  edges_.patch.Publish();
  if (edges_.steps != nullptr) edges_.steps->Push(sample_);
  for (TripleBuffer<SceneSnapshot>* edge : {&edges_.render, &edges_.telemetry}) {
    FillScene(tools, &edge->Back());
    edge->Publish();
  }
}

void DeformationLoop::FillScene(const ToolState& tools, SceneSnapshot* scene) const {
  scene->step = record_;
  scene->tool_count = tools.tool_count;
  scene->tools = tools.tools;
  scene->contacts = sample_.contacts;
  for (std::size_t o = 0; o < states_.size(); ++o) {
    OrganSnapshot& shape = scene->organs[o];
    shape.offset_W = states_[o].offset_W;
    if (shape.version == states_[o].version) continue;
    shape.version = states_[o].version;
    FillShape(models_[o], states_[o], &shape);
    if (shape.vertices.rows() == 0) continue;
    shape.vertices = states_[o].vertices.cast<float>();
    for (int i = 0; i < shape.indentation_count; ++i)
      models_[o].AddIndentation(shape.indentations[i], &shape.vertices);
  }
}

SceneSnapshot SizedSnapshot(const std::vector<OrganModel>& organs, int tool_count,
                            bool with_vertices) {
  SceneSnapshot scene;
  scene.tool_count = tool_count;
  for (const OrganModel& model : organs) {
    OrganSnapshot organ;
    const int slots = model.RefinementSlots(tool_count);
    organ.control_displacements = Points::Zero(model.control_points(), 3);
    organ.local_functions.assign(slots, -1);
    organ.local_displacements = Points::Zero(slots, 3);
    if (with_vertices) organ.vertices = model.rest().vertices.cast<float>();
    scene.organs.push_back(std::move(organ));
  }
  return scene;
}

}  // namespace hpdm
