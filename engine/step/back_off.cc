#include "engine/step/back_off.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace hpdm {
namespace {

// Load steps: this share of the way, or as much of it as belongs to the step's time.
constexpr double kShortest = 1.0 / 8;
constexpr double kWholeWay = 0.25;  // s
// A load step that fails at this share of the way is the last one.
constexpr double kLeast = 1.0 / 64;
// What is taken back goes to this share of the last sound way: at its end, the next iteration may
// fold the tissue.
constexpr double kBack = 0.9;

}  // namespace

BackOff::BackOff(const OrganModel& model, const OrganState& state)
    : model_(model),
      at_rest_(state.recovery),
      size_(model.lattice() ? model.lattice()->box().lengths.norm() : 0),
      sound_(Points::Zero(state.control_displacements.rows(), 3)),
      recovery_(state.recovery) {
  if (model.fold_watch() != nullptr) sweep_.emplace(*model.fold_watch());
}

RelaxationResult BackOff::Relax(double dt, OrganState* state) {
  const RelaxationResult result = RelaxSoundly(dt, state);
  if (model_.options().energy.strain == StrainMeasure::kAdaptive && sweep_) {
    WatchGradient(*state);
  }
  return result;
}

// What it was under contacts that are gone says nothing of the next.
void BackOff::WatchGradient(const OrganState& state) {
  if (state.contacts.size() == 0 || !state.control_displacements.allFinite()) {
    sweep_->part = 0;
    sweep_->gradients.fill(0);
    gradient_ = 0;
    return;
  }
  gradient_ = model_.fold_watch()->LargestGradient(state.contacts.local,
                                                   state.control_displacements, &*sweep_);
}

RelaxationResult BackOff::RelaxSoundly(double dt, OrganState* state) {
  folded_ = not_finite_ = false;
  const double demand = Demand(state->contacts);
  const bool is_free = state->contacts.size() == 0;
  if (IsLinear(*state) || is_free) {
    if (is_free || recovering_) Forget();
    const RelaxationResult result = RelaxWithin(demand, dt, state);
    not_finite_ = !state->control_displacements.allFinite();
    folded_ = !not_finite_ && Folds(*state);
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
  const RelaxationResult result = RelaxWithin(reach, dt, state);
  if (!Sound(demand, *state)) {
    const RelaxationResult second = TakeBack(demand, dt, state);
    // A replay obeys the first.
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

// How far the contacts' points are to go from rest, m: the farthest of them.
double BackOff::Demand(const ContactSet& contacts) const {
  double demand = 0;
  for (int i = 0; i < contacts.size(); ++i) {
    const ContactSet::Row& row = contacts[i];
    const Vector3d way = row.target_W - row.p_rest_W;
    const double length = row.kind == ContactSet::RowKind::kPress
                              ? std::max(0.0, -row.normal_W.dot(way))
                              : way.norm();
    demand = std::max(demand, length);
  }
  return demand;
}

// With every contact taken `reach` over the demand of its way.
RelaxationResult BackOff::RelaxWithin(double reach, double dt, OrganState* state) {
  ContactSet& contacts = state->contacts;
  const double demand = Demand(contacts);
  const double share = demand > reach ? reach / demand : 1;
  std::array<Vector3d, kMaxContacts> targets;
  for (int i = 0; i < contacts.size(); ++i) {
    ContactSet::Row& row = contacts[i];
    targets[i] = row.target_W;
    if (share < 1) row.target_W = row.p_rest_W + share * (row.target_W - row.p_rest_W);
  }
  const RelaxationResult result =
      state->recovery.Relax(dt, state->relaxation.get(), &contacts, &state->control_displacements);
  for (int i = 0; i < contacts.size(); ++i) contacts[i].target_W = targets[i];
  return result;
}

bool BackOff::IsLinear(const OrganState& state) const {
  return model_.finite_energy() == nullptr || state.quality.finite_share == 0;
}

bool BackOff::Folds(const OrganState& state) {
  if (!sweep_) return false;
  const int calls = IsLinear(state) ? kStepsASweep : 1;
  return model_.fold_watch()->Folded(state.contacts.local, state.control_displacements, calls,
                                     &*sweep_);
}

bool BackOff::Sound(double demand, const OrganState& state) {
  const Points& U = state.control_displacements;
  if (!U.allFinite()) {
    not_finite_ = true;
    return false;
  }
  const bool folds = Folds(state);
  folded_ = folded_ || folds;
  const bool blends = state.quality.finite_share < 1;
  return (blends || !folds) && U.cwiseAbs().maxCoeff() <= kFarthest * (demand + size_);
}

RelaxationResult BackOff::TakeBack(double demand, double dt, OrganState* state) {
  stride_ = recovering_ ? stride_ / 2 : std::clamp(dt / kWholeWay, kShortest, 1.0) * demand;
  if (stride_ < kLeast * demand) stride_ = 0;
  recovering_ = true;
  reach_ = sound_reach_ = kBack * std::min(sound_reach_, demand);
  state->recovery = recovery_;
  state->relaxation->RestartFrom(sound_);
  state->relaxation->StopNextAfter(1);
  const RelaxationResult result = RelaxWithin(reach_, dt, state);
  if (Sound(demand, *state)) {
    sound_ = state->control_displacements;
    return result;
  }
  sound_.setZero();
  sound_reach_ = reach_ = 0;
  stride_ = kShortest * demand;
  state->recovery = at_rest_;
  state->relaxation->RestartFrom(sound_);
  state->control_displacements.setZero();
  state->contacts.Clear();
  return result;
}

void BackOff::Forget() {
  recovering_ = false;
  sound_.setZero();
  sound_reach_ = 0;
}

}  // namespace hpdm
