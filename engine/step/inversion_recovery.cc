#include "engine/step/inversion_recovery.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hpdm {
namespace {

// The first load step is dt / kWholeWay of the demand, at least this share.
constexpr double kMinFirstLoadStep = 1.0 / 8;
constexpr double kWholeWay = 0.25;  // s
// A load step below this share of the demand becomes 0: the organ stays.
constexpr double kMinLoadStep = 1.0 / 64;
// A rejected step returns to this share of the last sound demand. At its full length the next
// iteration may invert the tissue.
constexpr double kBack = 0.9;
// Share of the volume that small strain may invert unnoticed: control points with a trace of tissue
// move by metres. At 0.0015, by a pull of 0.6 N on the last tenth of a gallbladder's bed, a picture shows
// nothing.
constexpr double kTrace = 0.002;

}  // namespace

InversionRecovery::InversionRecovery(const OrganModel& model, const OrganState& state)
    : model_(&model),
      lattice_organ_(model.lattice_organ()),
      at_rest_(state.memory),
      size_(lattice_organ_ != nullptr ? lattice_organ_->lattice().box().lengths.norm() : 0),
      sound_(Points::Zero(state.control_displacements.rows(), 3)) {
  if (lattice_organ_ != nullptr) scan_.emplace(lattice_organ_->inversion_detector());
}

void InversionRecovery::Begin(double dt, OrganState* state) {
  inverted_ = not_finite_ = false;
  dt_ = dt;
  demand_ = Demand(state->contacts);
  for (int i = 0; i < state->contacts.size(); ++i) targets_[i] = state->contacts[i].target_W;
  const bool is_free = state->contacts.size() == 0;
  input_ = TakeInput(*state);
  double reach = demand_;
  if (IsLinear(*state) || is_free) {
    attempt_ = Attempt::kOnly;
    if (is_free || recovering_) Reset();
  } else {
    attempt_ = Attempt::kFirst;
    recovering_ = recovering_ && demand_ > reach_;
    if (recovering_) reach = reach_ = std::min(demand_, sound_reach_ + stride_);
  }
  ReachFor(reach, state);
  state->memory.Begin(dt, &state->contacts, &input_);
}

bool InversionRecovery::Rejects(const RelaxationResult& result, OrganState* state) {
  if (attempt_ != Attempt::kFirst || Sound(demand_, *state)) return false;
  first_ = result;
  attempt_ = Attempt::kSecond;
  stride_ =
      recovering_ ? stride_ / 2 : std::clamp(dt_ / kWholeWay, kMinFirstLoadStep, 1.0) * demand_;
  if (stride_ < kMinLoadStep * demand_) stride_ = 0;
  recovering_ = true;
  reach_ = sound_reach_ = kBack * std::min(sound_reach_, demand_);
  ReachFor(reach_, state);
  state->memory.Cancel(&state->contacts);
  input_ = {.quality = state->quality, .stop_after = 1, .start = &sound_};
  state->memory.Begin(dt_, &state->contacts, &input_);
  return true;
}

void InversionRecovery::End(const RelaxationResult& result, OrganState* state) {
  SetTargetsBack(state);
  state->memory.End(&state->contacts, &state->control_displacements);
  state->relaxed = result;
  if (attempt_ == Attempt::kSecond) {
    EndSecond(state);
  } else {
    Judge(state);
  }
  if (model_->options().energy.strain == StrainMeasure::kAdaptive && scan_) WatchGradient(*state);
}

// Takes over the state of an attempt that was not rejected.
void InversionRecovery::Judge(OrganState* state) {
  if (attempt_ == Attempt::kFirst) {
    sound_ = state->control_displacements;
    sound_reach_ = recovering_ ? reach_ : demand_;
    recovering_ = recovering_ && reach_ < demand_;
    return;
  }
  not_finite_ = !state->control_displacements.allFinite();
  inverted_ = !not_finite_ && IsInverted(*state);
  const bool is_free = state->contacts.size() == 0;
  if (model_->finite_energy() == nullptr || is_free || not_finite_) return;
  sound_ = state->control_displacements;
  sound_reach_ = demand_;
}

// A replay applies the first attempt's iterations.
void InversionRecovery::EndSecond(OrganState* state) {
  state->relaxed.iterations = first_.iterations;
  state->relaxed.out_of_time = first_.out_of_time;
  state->relaxed.converged = false;
  if (Sound(demand_, *state)) {
    sound_ = state->control_displacements;
    return;
  }
  sound_.setZero();
  sound_reach_ = reach_ = 0;
  stride_ = kMinFirstLoadStep * demand_;
  state->memory = at_rest_;
  starts_at_rest_ = true;
  state->control_displacements.setZero();
  state->contacts.Clear();
}

// The gradient under contacts that have ended does not apply to the next contacts.
void InversionRecovery::WatchGradient(const OrganState& state) {
  if (state.contacts.size() == 0 || !state.control_displacements.allFinite()) {
    scan_->part = 0;
    scan_->gradients.fill(0);
    gradient_ = 0;
    return;
  }
  gradient_ = lattice_organ_->inversion_detector().LargestGradient(
      state.contacts.refinement, state.control_displacements, &*scan_);
}

// Returns the largest distance of a contact's target from rest, m.
double InversionRecovery::Demand(const ContactConstraints& contacts) const {
  double demand = 0;
  for (int i = 0; i < contacts.size(); ++i) {
    const ContactConstraints::Row& row = contacts[i];
    const Vector3d way = row.target_W - row.p_rest_W;
    const double length = row.kind == ContactConstraints::RowKind::kPress
                              ? std::max(0.0, -row.normal_W.dot(way))
                              : way.norm();
    demand = std::max(demand, length);
  }
  return demand;
}

// Scales every target from rest by `reach` over the demand.
void InversionRecovery::ReachFor(double reach, OrganState* state) {
  SetTargetsBack(state);
  if (!(demand_ > reach)) return;
  const double share = reach / demand_;
  for (int i = 0; i < state->contacts.size(); ++i) {
    ContactConstraints::Row& row = state->contacts[i];
    row.target_W = row.p_rest_W + share * (row.target_W - row.p_rest_W);
  }
}

void InversionRecovery::SetTargetsBack(OrganState* state) const {
  for (int i = 0; i < state->contacts.size(); ++i) state->contacts[i].target_W = targets_[i];
}

// Returns the input of this step's relaxation. `sound_` is at rest where the last step reset it.
RelaxationInput InversionRecovery::TakeInput(const OrganState& state) {
  return {.quality = state.quality,
          .stop_after = std::exchange(stop_after_, 0),
          .start = std::exchange(starts_at_rest_, false) ? &sound_ : nullptr};
}

bool InversionRecovery::IsLinear(const OrganState& state) const {
  return model_->finite_energy() == nullptr || state.quality.finite_strain_blend == 0;
}

bool InversionRecovery::IsInverted(const OrganState& state) {
  if (!scan_) return false;
  const int calls = IsLinear(state) ? kStepsPerScan : 1;
  const bool any = lattice_organ_->inversion_detector().Inverted(
      state.contacts.refinement, state.control_displacements, calls, &*scan_);
  return IsLinear(state) ? scan_->share > kTrace : any;
}

bool InversionRecovery::Sound(double demand, const OrganState& state) {
  const Points& U = state.control_displacements;
  if (!U.allFinite()) {
    not_finite_ = true;
    return false;
  }
  const bool inverted = IsInverted(state);
  inverted_ = inverted_ || inverted;
  const bool blends = state.quality.finite_strain_blend < 1;
  return (blends || !inverted) && U.cwiseAbs().maxCoeff() <= kMaxExcursion * (demand + size_);
}

void InversionRecovery::Reset() {
  recovering_ = false;
  sound_.setZero();
  sound_reach_ = 0;
}

}  // namespace hpdm
