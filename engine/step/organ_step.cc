#include "engine/step/organ_step.h"

#include <algorithm>
#include <utility>

#include "engine/lattice/direct_manipulation.h"
#include "engine/step/demanded_move.h"

namespace hpdm {

OrganStep::OrganStep(const OrganModel& model, int tools, std::function<Nanoseconds()> clock)
    : model_(&model),
      state_(model, tools, std::move(clock)),
      inversion_recovery_(model, state_),
      blend_controller_(model.options()) {}

void OrganStep::ApplyRecorded(const OrganRelaxation& recorded) {
  if (recorded.out_of_time) {
    inversion_recovery_.StopNextAfter(recorded.iterations);
    state_.awake = true;
  }
  state_.quality.finite_strain_blend = recorded.finite_strain_blend;
  state_.quality.refinement_weight = recorded.refinement_weight;
  applies_recorded_ = true;
}

void OrganStep::ChooseQuality(const QualityCeiling& ceiling) {
  const StepQuality chosen =
      blend_controller_.Next(ceiling, state_.contacts.size() > 0, inversion_recovery_.gradient(),
                             state_.relaxed.share_slope);
  if (applies_recorded_) {
    state_.quality.newton_iterations = chosen.newton_iterations;
    blend_controller_.ApplyRecorded(state_.quality);
  } else {
    state_.quality = chosen;
  }
  applies_recorded_ = false;
}

void OrganStep::Begin(Nanoseconds time_ns) {
  state_.offset_last_W = state_.offset_W;
  state_.offset_W = model_->options().motion.Offset(time_ns);
  if (!state_.tree_fits) state_.tree.Refit(state_.vertices);
  state_.tree_fits = true;
  state_.contacts.Clear();
}

void OrganStep::Refine(std::span<const Vector3d> p_rest_W, std::uint64_t step) {
  const RefinementBasis* basis = model_->refinement_basis();
  if (basis == nullptr) return;
  ActiveRefinement& active = state_.contacts.refinement;
  if (p_rest_W.empty() && active.used() == 0) return;
  active.ChooseNearest(basis->centres(), p_rest_W, LocalFunctionsOf(model_->options()),
                       state_.quality.refinement_weight);
  bool changed = false;
  for (int s = 0; s < active.slots(); ++s) {
    const int row = model_->control_points() + s;
    state_.memory.ScaleRow(row, active.Kept(s));
    if (!active.Changed(s)) continue;
    state_.control_displacements.row(row).setZero();
    inversion_recovery_.ResetRow(row);
    changed = true;
  }
  state_.relaxation->SetActiveFunctions(active);
  if (changed) state_.version = step;
}

void OrganStep::RepositionControlPoints() {
  if (!state_.awake) return;
  const int rows = state_.contacts.tool_rows();
  Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor, kMaxToolRows, 3> change(rows, 3);
  for (int i = 0; i < rows; ++i) change.row(i) = DemandedMove(state_, i);
  // The lattice hardly tells the rows of a footprint apart: their local compliance does. Moved one
  // by one they would throw the control points far away.
  for (int i = 0; i < rows; ++i) {
    const LocalCoupling* coupling = state_.contacts[i].coupled.coupling;
    const bool held = state_.contacts[i].kind == ContactConstraints::RowKind::kGrasp;
    if (!held || coupling == nullptr || state_.contacts[i].coupled.place != 0) continue;
    const int count = static_cast<int>(coupling->rows()) / 3;
    const int last = std::min(i + count, rows);
    const Eigen::RowVector3d mean = change.middleRows(i, last - i).colwise().mean();
    for (int j = i; j < last; ++j) change.row(j) = mean;
  }
  MoveDirectly(state_.contacts.Weights().topRows(rows), change, state_.control_displacements);
}

BodyInStep OrganStep::Body() {
  return {state_.relaxation->body(), &state_.contacts, &state_.control_displacements, Input()};
}

RelaxationInput OrganStep::Input() const {
  RelaxationInput input = inversion_recovery_.input();
  // A leaking organ is elastic: nothing else moves it without forces.
  if (const Points* lost = state_.leaks.displacements()) input.free = lost;
  return input;
}

RelaxationResult OrganStep::RelaxAlone() {
  return state_.relaxation->Relax(&state_.contacts, &state_.control_displacements, Input());
}

void OrganStep::EndRelax(const RelaxationResult& result, StepRecord* record) {
  state_.awake = state_.awake || IsPressedByOrgans();
  inversion_recovery_.End(result, &state_);
  if (!state_.control_displacements.allFinite()) {
    state_.control_displacements.setZero();
    state_.contacts.Clear();
  }
  if (inversion_recovery_.not_finite()) record->flags |= kStepNotFinite;
  if (inversion_recovery_.inverted()) record->flags |= kStepInverted;
  if (inversion_recovery_.recovering()) record->flags |= kStepRecovering;
  if (!state_.relaxed.converged) record->flags |= kStepBudgetSpent;
  if (state_.relaxed.regularised) record->flags |= kStepContactsRegularised;
  record->iterations += state_.relaxed.iterations;
  record->residual = std::max(record->residual, state_.relaxed.residual);
}

bool OrganStep::IsPressedByOrgans() const {
  for (int i = state_.contacts.tool_rows(); i < state_.contacts.size(); ++i) {
    if (!state_.contacts[i].force_W.isZero(0)) return true;
  }
  return false;
}

// True if an untouched next step would leave the organ unchanged. A scan of the inversion detector
// in progress must end first.
bool OrganStep::AtRest() const {
  return state_.contacts.tool_rows() == 0 && !IsPressedByOrgans() &&
         state_.control_displacements.isZero(0) && state_.memory.AtRest() &&
         state_.relaxation->AtRest() && !inversion_recovery_.inverted() && !state_.leaks.IsActive();
}

void OrganStep::RelocateVertices(std::uint64_t step) {
  if (!state_.awake) return;
  state_.awake = !AtRest();
  if (model_->rigid()) return;
  model_->relocation().Relocate(state_.control_displacements, &state_.vertices);
  model_->AddLocalDisplacements(state_.contacts.refinement, state_.control_displacements,
                                &state_.vertices);
  state_.leaks.FindPressures(state_.vertices, state_.relaxation->Rotation());
  state_.tree_fits = false;
  state_.version = step;
}

OrganRelaxation OrganStep::Outcome() const {
  return {state_.relaxed.iterations,
          state_.relaxed.out_of_time,
          inversion_recovery_.inverted(),
          inversion_recovery_.recovering(),
          state_.quality.finite_strain_blend,
          state_.quality.refinement_weight,
          state_.relaxation->BodyEnergy(state_.control_displacements)};
}

void OrganStep::FillSnapshot(OrganSnapshot* shape) const {
  shape->offset_W = state_.offset_W;
  if (shape->version == state_.version) return;
  shape->version = state_.version;
  const int n = model_->control_points();
  const ActiveRefinement& active = state_.contacts.refinement;
  if (shape->vertices.rows() == 0 && model_->HasSplitFunctions()) {
    shape->control_displacements = state_.vertices - model_->rest().vertices;
  } else {
    shape->control_displacements = state_.control_displacements.topRows(n);
    shape->local_displacements = state_.control_displacements.bottomRows(active.slots());
  }
  for (int s = 0; s < static_cast<int>(shape->local_functions.size()); ++s) {
    const int function = active.Function(s);
    shape->local_functions[s] =
        function < 0 ? -1 : model_->refinement_basis()->finer().kept()[function];
  }
  shape->indentation_count = 0;
  for (const MaxwellMemory::Dent& dent : state_.memory.dents()) {
    const Vector3d& force_W = dent.memory.equilibrium_force_W();
    const double pressing = -dent.indentation.normal_W().dot(force_W);
    if (!dent.used || !dent.indentation.indents() || !(pressing > 0)) continue;
    shape->indentations[shape->indentation_count++] =
        AppliedIndentation(dent.indentation.UnderBall(pressing), dent.p_rest_W, force_W);
  }
  for (int i = 0; i < state_.contacts.size() && state_.memory.IsElastic(); ++i) {
    const ContactConstraints::Row& row = state_.contacts[i];
    if (!row.indentation.indents() || !(row.f_n() > 0)) continue;
    if (shape->indentation_count == kMaxInstruments) break;
    IndentationSnapshot& applied = shape->indentations[shape->indentation_count++];
    const Vector3d p_rest_W =
        state_.RestOfTurned(*model_, row.p_rest_W, state_.contacts.Weights().row(i));
    applied = AppliedIndentation(row.indentation.UnderBall(row.f_n()), p_rest_W, row.force_W);
    applied.normal_W = state_.relaxation->Rotation().transpose() * applied.normal_W;
  }
  if (shape->vertices.rows() == 0) return;
  shape->vertices = state_.vertices.cast<float>();
  for (int i = 0; i < shape->indentation_count; ++i) {
    model_->AddIndentation(shape->indentations[i], &shape->vertices);
  }
}

}  // namespace hpdm
