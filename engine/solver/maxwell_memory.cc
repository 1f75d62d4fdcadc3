#include "engine/solver/maxwell_memory.h"

#include <algorithm>
#include <utility>

namespace hpdm {
namespace {

constexpr double kMinStep = 1e-4;  // s

MaxwellState<Vector3d> AtRestState() { return {Vector3d::Zero(), NoBranchStrains()}; }

}  // namespace

MaxwellMemory::MaxwellMemory(const PronySeries& prony, int n,
                             std::shared_ptr<ElasticSupports> supports)
    : prony_(prony), supports_(std::move(supports)) {
  if (IsElastic()) return;
  if (supports_ != nullptr && supports_->modes() == 0) supports_ = nullptr;
  state_.at = Points::Zero(n, 3);
  if (supports_ != nullptr) strains_.fill(state_.at);
  for (Points& branch : state_.branches) branch = state_.at;
  from_ = free_ = start_ = state_.at;
  for (Held& held : held_) held.states.fill(AtRestState());
}

MaxwellMemory::Part MaxwellMemory::PartOf(const ContactConstraints::Row& row) {
  if (row.shaft || row.tool < 0 || row.tool >= kMaxInstruments) return Part::kNone;
  if (row.kind == ContactConstraints::RowKind::kPress) return Part::kDent;
  return row.kind == ContactConstraints::RowKind::kGrasp ? Part::kFootprint : Part::kNone;
}

void MaxwellMemory::Begin(double dt, ContactConstraints* contacts, RelaxationInput* input) {
  if (IsElastic()) return;
  step_ = MaxwellStep(prony_, std::max(dt, kMinStep));
  // The damper's load at rest, -damping K from, is that of the memory.
  input->damping = step_.stiffening - 1;
  from_ = state_.at;
  for (int i = 0; i < step_.count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    from_ -= step_.ratio[k] * step_.decay[k] / input->damping * state_.branches[k];
  }
  input->damped_from = &from_;
  free_ = (1 - 1 / step_.stiffening) * from_;
  if (supports_ != nullptr) supports_->AddFree(input->damping, from_, &free_);
  input->supports = supports_.get();
  input->free = &free_;
  input->yield = 1 / step_.stiffening;
  if (input->start == nullptr) {
    start_ = state_.at;
    input->start = &start_;
  }
  for (Dent& dent : dents_) dent.pressed = false;
  std::array<int, kMaxInstruments> rows{};
  for (int i = 0; i < contacts->size(); ++i) {
    ContactConstraints::Row& row = (*contacts)[i];
    indentations_[static_cast<std::size_t>(i)] = row.indentation;
    const Part part = PartOf(row);
    if (part == Part::kDent) BeginDent(&row);
    if (part != Part::kFootprint) continue;
    int& count = rows[static_cast<std::size_t>(row.tool)];
    place_[static_cast<std::size_t>(i)] = count;
    BeginFootprint(&row, count++);
  }
  for (std::size_t t = 0; t < held_.size(); ++t) held_[t].rows = rows[t];
}

void MaxwellMemory::BeginDent(ContactConstraints::Row* row) {
  Dent& dent = DentOf(*row);
  if (dent.used) {
    dent.memory.Slide((row->p_rest_W - dent.p_rest_W).norm(), row->indentation.radius());
  }
  dent.used = dent.pressed = true;
  dent.indentation = row->indentation;
  dent.p_rest_W = row->p_rest_W;
  row->indentation = dent.memory.Law(row->indentation, step_, &row->free_W);
}

// A row that the last step did not have begins without memory.
void MaxwellMemory::BeginFootprint(ContactConstraints::Row* row, int place) {
  Held& held = held_[static_cast<std::size_t>(row->tool)];
  MaxwellState<Vector3d>& state = held.states[static_cast<std::size_t>(place)];
  if (place >= held.rows) state = AtRestState();
  Vector3d memory_W;
  state.Memory(step_, Vector3d::Zero(), &memory_W);
  row->free_W = -memory_W / step_.stiffening;
  row->local_compliance_W /= step_.stiffening;
  if (row->coupled.coupling == nullptr) return;
  if (place == 0) {
    held.coupling = row->coupled.coupling;
    held.stiffer = *held.coupling / step_.stiffening;
  }
  row->coupled.coupling = &held.stiffer;
}

void MaxwellMemory::End(ContactConstraints* contacts, Points* U) {
  if (IsElastic()) return;
  EndLocalParts(contacts);
  state_.Advance(step_, *U);
  for (int i = 0; i < step_.count && supports_ != nullptr; ++i) {
    const auto k = static_cast<std::size_t>(i);
    strains_[k] = state_.branches[k];
    supports_->TakeOut(&strains_[k]);
  }
  if (!U->allFinite()) {  // the caller reports it; the next step starts at rest
    SetToRest();
    return;
  }
  bool moves = !U->isZero(kStill);
  for (int i = 0; i < contacts->size(); ++i) moves = moves || !(*contacts)[i].force_W.isZero(0);
  for (const Points& branch : state_.branches) moves = moves || !branch.isZero(kStill);
  for (const Dent& dent : dents_) moves = moves || dent.used;
  if (moves) return;
  SetToRest();
  U->setZero();
}

void MaxwellMemory::EndLocalParts(ContactConstraints* contacts) {
  for (int i = 0; i < contacts->size(); ++i) {
    const auto index = static_cast<std::size_t>(i);
    ContactConstraints::Row& row = (*contacts)[i];
    LocalPart& local = local_[index];
    local = {};
    local.displacement_W = row.free_W + row.LocalCompliance() * row.force_W;
    for (int j = 0; j < contacts->size(); ++j) {
      if (j == i) continue;
      local.displacement_W += row.coupled.To((*contacts)[j].coupled) * (*contacts)[j].force_W;
    }
    const Part part = PartOf(row);
    if (part == Part::kDent) {
      Dent& dent = DentOf(row);
      dent.memory.Advance(step_, row.force_W);
      local.equilibrium_force_W = dent.memory.equilibrium_force_W();
    } else if (part == Part::kFootprint) {
      MaxwellState<Vector3d>& state =
          held_[static_cast<std::size_t>(row.tool)].states[static_cast<std::size_t>(place_[index])];
      state.Advance(step_, local.displacement_W);
      local.branches_W = state.branches;
    }
  }
  Cancel(contacts);
  for (Dent& dent : dents_) {
    if (!dent.used || dent.pressed) continue;
    dent.memory.Advance(step_, Vector3d::Zero());
    const double force = dent.memory.equilibrium_force_W().norm();
    const double sunk =
        dent.indentation.BallYield(force) * dent.indentation.factor_W().norm() * force;
    if (!(sunk > kStill)) dent = {};
  }
}

void MaxwellMemory::Cancel(ContactConstraints* contacts) const {
  if (IsElastic()) return;
  for (int i = 0; i < contacts->size(); ++i) {
    ContactConstraints::Row& row = (*contacts)[i];
    if (PartOf(row) == Part::kFootprint) {
      row.local_compliance_W *= step_.stiffening;
      if (row.coupled.coupling != nullptr) {
        row.coupled.coupling = held_[static_cast<std::size_t>(row.tool)].coupling;
      }
    }
    row.indentation = indentations_[static_cast<std::size_t>(i)];
  }
}

void MaxwellMemory::SetToRest() {
  state_.at.setZero();
  for (Points& branch : state_.branches) branch.setZero();
  if (supports_ != nullptr) {
    for (Points& strain : strains_) strain.setZero();
  }
  dents_ = {};
  for (Held& held : held_) held.rows = 0;
}

bool MaxwellMemory::AtRest() const {
  if (IsElastic()) return true;
  for (const Points& branch : state_.branches) {
    if (!branch.isZero(0)) return false;
  }
  return state_.at.isZero(0) &&
         std::none_of(dents_.begin(), dents_.end(), [](const Dent& dent) { return dent.used; });
}

void MaxwellMemory::ScaleRow(int row, double share) {
  if (IsElastic()) return;
  state_.at.row(row) *= share;
  for (Points& branch : state_.branches) branch.row(row) *= share;
}

BranchStrains MaxwellMemory::BranchesAt(const SparseRow& b) const {
  BranchStrains strains = NoBranchStrains();
  const auto& branches = supports_ != nullptr ? strains_ : state_.branches;
  for (int i = 0; i < prony_.count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    for (std::size_t a = 0; a < b.control_points.size(); ++a) {
      strains[k] += b.weights[a] * branches[k].row(b.control_points[a]).transpose();
    }
  }
  return strains;
}

Vector3d MaxwellMemory::Excess(const BranchStrains& branches_W) const {
  Vector3d sum_W = Vector3d::Zero();
  for (int i = 0; i < prony_.count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    sum_W += prony_.terms[k].share / (1 - prony_.Share()) * branches_W[k];
  }
  return sum_W;
}

}  // namespace hpdm
