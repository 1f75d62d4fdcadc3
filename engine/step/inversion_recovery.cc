#include "engine/step/inversion_recovery.h"

#include <algorithm>
#include <array>
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

}  // namespace

InversionRecovery::InversionRecovery(const OrganModel& model, const OrganState& state)
    : model_(model),
      lattice_organ_(model.lattice_organ()),
      at_rest_(state.recovery),
      size_(lattice_organ_ != nullptr ? lattice_organ_->lattice().box().lengths.norm() : 0),
      sound_(Points::Zero(state.control_displacements.rows(), 3)),
      recovery_(state.recovery) {
  if (lattice_organ_ != nullptr) scan_.emplace(lattice_organ_->inversion_detector());
}

RelaxationResult InversionRecovery::Relax(double dt, OrganState* state) {
  const RelaxationResult result = RelaxSoundly(dt, state);
  if (model_.options().energy.strain == StrainMeasure::kAdaptive && scan_) {
    WatchGradient(*state);
  }
  return result;
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

RelaxationResult InversionRecovery::RelaxSoundly(double dt, OrganState* state) {
  inverted_ = not_finite_ = false;
  const double demand = Demand(state->contacts);
  const bool is_free = state->contacts.size() == 0;
  const RelaxationInput input = TakeInput(*state);
  if (IsLinear(*state) || is_free) {
    if (is_free || recovering_) Reset();
    const RelaxationResult result = RelaxWithin(demand, dt, input, state);
    not_finite_ = !state->control_displacements.allFinite();
    inverted_ = !not_finite_ && IsInverted(*state);
    if (model_.finite_energy() != nullptr && !is_free && !not_finite_) {
      sound_ = state->control_displacements;
      sound_reach_ = demand;
    }
    return result;
  }
  recovering_ = recovering_ && demand > reach_;
  if (recovering_) reach_ = std::min(demand, sound_reach_ + stride_);
  const double reach = recovering_ ? reach_ : demand;
  recovery_ = state->recovery;
  const RelaxationResult result = RelaxWithin(reach, dt, input, state);
  if (!Sound(demand, *state)) {
    const RelaxationResult second = RejectStep(demand, dt, state);
    // A replay applies the first solve's iterations.
    return {.iterations = result.iterations,
            .residual = second.residual,
            .converged = false,
            .regularised = second.regularised,
            .out_of_time = result.out_of_time,
            .share_slope = second.share_slope};
  }
  sound_ = state->control_displacements;
  sound_reach_ = reach;
  recovering_ = recovering_ && reach < demand;
  return result;
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

// Relaxes with every target scaled from rest by `reach` over the demand.
RelaxationResult InversionRecovery::RelaxWithin(double reach, double dt,
                                                const RelaxationInput& input, OrganState* state) {
  ContactConstraints& contacts = state->contacts;
  const double demand = Demand(contacts);
  const double share = demand > reach ? reach / demand : 1;
  std::array<Vector3d, kMaxContacts> targets;
  for (int i = 0; i < contacts.size(); ++i) {
    ContactConstraints::Row& row = contacts[i];
    targets[i] = row.target_W;
    if (share < 1) row.target_W = row.p_rest_W + share * (row.target_W - row.p_rest_W);
  }
  const RelaxationResult result = state->recovery.Relax(dt, state->relaxation.get(), &contacts,
                                                        &state->control_displacements, input);
  for (int i = 0; i < contacts.size(); ++i) contacts[i].target_W = targets[i];
  return result;
}

// Returns the input of this step's relaxation. `sound_` is at rest where the last step reset it.
RelaxationInput InversionRecovery::TakeInput(const OrganState& state) {
  return {.quality = state.quality,
          .stop_after = std::exchange(stop_after_, 0),
          .start = std::exchange(starts_at_rest_, false) ? &sound_ : nullptr};
}

bool InversionRecovery::IsLinear(const OrganState& state) const {
  return model_.finite_energy() == nullptr || state.quality.finite_strain_blend == 0;
}

bool InversionRecovery::IsInverted(const OrganState& state) {
  if (!scan_) return false;
  const int calls = IsLinear(state) ? kStepsPerScan : 1;
  return lattice_organ_->inversion_detector().Inverted(state.contacts.refinement,
                                                       state.control_displacements, calls, &*scan_);
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

RelaxationResult InversionRecovery::RejectStep(double demand, double dt, OrganState* state) {
  stride_ = recovering_ ? stride_ / 2 : std::clamp(dt / kWholeWay, kMinFirstLoadStep, 1.0) * demand;
  if (stride_ < kMinLoadStep * demand) stride_ = 0;
  recovering_ = true;
  reach_ = sound_reach_ = kBack * std::min(sound_reach_, demand);
  state->recovery = recovery_;
  const RelaxationResult result = RelaxWithin(
      reach_, dt, {.quality = state->quality, .stop_after = 1, .start = &sound_}, state);
  if (Sound(demand, *state)) {
    sound_ = state->control_displacements;
    return result;
  }
  sound_.setZero();
  sound_reach_ = reach_ = 0;
  stride_ = kMinFirstLoadStep * demand;
  state->recovery = at_rest_;
  starts_at_rest_ = true;
  state->control_displacements.setZero();
  state->contacts.Clear();
  return result;
}

void InversionRecovery::Reset() {
  recovering_ = false;
  sound_.setZero();
  sound_reach_ = 0;
}

}  // namespace hpdm
