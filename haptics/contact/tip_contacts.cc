#include "haptics/contact/tip_contacts.h"

#include <algorithm>
#include <span>

namespace hpdm {
namespace {

// Rounds over all contacts on the organs that shafts touch, and the last change of a force over the
// largest. Each round solves every contact with the others' last forces (block Gauss-Seidel).
constexpr int kMaxContactRounds = 12;
constexpr double kSettledChange = 1e-9;

}  // namespace

TipContacts::TipContacts(double period) {
  places_.fill(HapticContact(period));
  std::fill(places_.begin() + kMaxPlaces, places_.end(),
            HapticContact(period, HapticContact::Part::kShaft));
}

void TipContacts::SetPatches(const ToolPatches& patches) noexcept {
  static_assert(kShaftPlaces == 2);
  const HapticContact &one = places_[kMaxPlaces], &other = places_[kMaxPlaces + 1];
  const ToolPatch &first = patches.places[kMaxPlaces], &second = patches.places[kMaxPlaces + 1];
  const double straight = one.DistanceTo(first) + other.DistanceTo(second);
  const double crossed = one.DistanceTo(second) + other.DistanceTo(first);
  if (straight != crossed) shafts_crossed_ = crossed < straight;
  for (std::size_t p = 0; p < places_.size(); ++p) places_[p].SetPatch(patches.places[Slot(p)]);
}

// Returns the step's number of a place.
std::size_t TipContacts::Slot(std::size_t place) const {
  const bool crossed = shafts_crossed_ && place >= kMaxPlaces;
  return crossed ? 2 * kMaxPlaces + 1 - place : place;
}

void TipContacts::Rebind(const ToolPatches& patches) noexcept {
  for (std::size_t p = 0; p < places_.size(); ++p) places_[p].Rebind(patches.places[Slot(p)]);
}

void TipContacts::ClearPatches() noexcept {
  for (HapticContact& place : places_) place.ClearPatch();
}

void TipContacts::Locate(const TipPose& tip) noexcept {
  TipPose shaft = tip;
  for (int p = 0; p < kMaxPlaces; ++p) {
    shaft.tip_part = std::max(shaft.tip_part, tip.tip_part + result(p).depth);
  }
  for (HapticContact& place : Tips()) place.Locate(tip);
  static_assert(kShaftPlaces == 2);
  HapticContact &one = places_[kMaxPlaces], &other = places_[kMaxPlaces + 1];
  one.KeepApartFrom(other);
  one.Locate(shaft);
  other.KeepApartFrom(one);
  other.Locate(shaft);
}

void TipContacts::Solve(TipContacts* tip) noexcept {
  if (tip->ShaftPresses()) {
    Rounds(tip, nullptr);
  } else {
    FindTipForces(tip, nullptr);
  }
  tip->Finish();
}

void TipContacts::Solve(TipContacts* a, TipContacts* c) noexcept {
  if (a->ShaftPresses() || c->ShaftPresses()) {
    Rounds(a, c);
  } else {
    FindTipForces(a, c);
  }
  a->Finish();
  c->Finish();
}

// Finds the forces of all tips, two on one organ together.
void TipContacts::FindTipForces(TipContacts* a, TipContacts* c) {
  for (HapticContact& place : a->Tips()) {
    HapticContact* const other = c == nullptr ? nullptr : c->OnOrgan(place.organ());
    if (other == nullptr) {
      place.FindForce();
    } else {
      HapticContact::FindForces(&place, other);
    }
  }
  if (c == nullptr) return;
  for (HapticContact& place : c->Tips()) {
    if (a->OnOrgan(place.organ()) == nullptr) place.FindForce();
  }
}

// Finds the forces of all contacts, with those of the shafts.
void TipContacts::Rounds(TipContacts* a, TipContacts* c) {
  struct Member {
    HapticContact* contact;
    int tool, place;
    bool is_shaft() const { return place >= kMaxPlaces; }
  };
  constexpr std::size_t kMaxMembers = kMaxInstruments * kToolPlaces;
  std::array<Member, kMaxMembers> members;
  std::size_t count = 0;
  for (int tool = 0; tool < kMaxInstruments; ++tool) {
    TipContacts* const contacts = tool == 0 ? a : c;
    if (contacts == nullptr) continue;
    for (int p = 0; p < kToolPlaces; ++p) {
      HapticContact* const contact = &contacts->places_[static_cast<std::size_t>(p)];
      const int slot = static_cast<int>(contacts->Slot(static_cast<std::size_t>(p)));
      if (contact->InLattice()) members[count++] = {contact, tool, slot};
    }
  }
  std::array<std::array<Matrix3d, kMaxMembers>, kMaxMembers> coupling_W;
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Member &one = members[i], &other = members[j];
      coupling_W[i][j].setZero();
      if (one.contact->organ() == other.contact->organ()) {
        coupling_W[i][j] = one.contact->CouplingTo(other.tool, other.place);
        if (coupling_W[i][j].isZero(0)) {
          coupling_W[i][j] = other.contact->CouplingTo(one.tool, one.place).transpose();
        }
      }
      coupling_W[j][i] = coupling_W[i][j].transpose();
    }
  }
  std::array<Vector3d, kMaxMembers> last_W;
  for (std::size_t i = 0; i < count; ++i) last_W[i] = members[i].contact->found_W();
  const auto push = [&](std::size_t i) {
    Vector3d moved_W = Vector3d::Zero();
    for (std::size_t j = 0; j < count; ++j) {
      if (j != i) moved_W += coupling_W[i][j] * last_W[j];
    }
    members[i].contact->PushTo(moved_W);
  };
  for (int round = 0; round < kMaxContactRounds; ++round) {
    double change = 0, largest = 0;
    const auto take = [&](std::size_t i) {
      change = std::max(change, (members[i].contact->found_W() - last_W[i]).norm());
      last_W[i] = members[i].contact->found_W();
      largest = std::max(largest, last_W[i].norm());
    };
    for (std::size_t i = 0; i < count; ++i) {
      if (!members[i].is_shaft()) push(i);
    }
    FindTipForces(a, c);
    for (std::size_t i = 0; i < count; ++i) {
      if (!members[i].is_shaft()) take(i);
    }
    for (std::size_t i = 0; i < count; ++i) {
      if (!members[i].is_shaft()) continue;
      push(i);
      members[i].contact->FindForce();
      take(i);
    }
    if (!(change > kSettledChange * largest)) break;
  }
}

bool TipContacts::ShaftPresses() const {
  return std::any_of(places_.begin() + kMaxPlaces, places_.end(),
                     [](const HapticContact& place) { return place.InLattice(); });
}

std::span<HapticContact> TipContacts::Tips() { return std::span(places_).first<kMaxPlaces>(); }

// Returns the tip's contact with an organ's patch; nullptr if there is none.
HapticContact* TipContacts::OnOrgan(int organ) {
  if (organ < 0) return nullptr;
  const std::span<HapticContact> tips = Tips();
  const auto found = std::find_if(tips.begin(), tips.end(),
                                  [organ](const HapticContact& p) { return p.organ() == organ; });
  return found == tips.end() ? nullptr : &*found;
}

void TipContacts::Finish() {
  for (HapticContact& place : places_) place.Apply();
  const auto weight = [](const HapticContact& place) {
    const HapticForce& force = place.result();
    return force.kind == ContactKind::kGrasp ? 1e300 : force.reaction_W.squaredNorm();
  };
  const auto main =
      std::max_element(places_.begin(), places_.end(),
                       [&](const auto& a, const auto& c) { return weight(a) < weight(c); });
  result_ = main->result();
  double most_stored = result_.stored;
  for (const HapticContact& place : places_) {
    if (&place == &*main) continue;
    const HapticForce& force = place.result();
    if (force.reaction_W.squaredNorm() != 0) result_.reaction_W += force.reaction_W;
    result_.wall_W += force.wall_W;
    result_.stored += force.stored;
    if (force.stored <= most_stored) continue;
    most_stored = force.stored;
    result_.p_tip_organ_W = force.p_tip_organ_W;
  }
}

bool TipContacts::IsFree() const noexcept {
  return std::all_of(places_.begin(), places_.end(),
                     [](const HapticContact& place) { return place.IsFree(); });
}

std::array<TickContactPoint, kToolPlaces> TipContacts::contact_points() const noexcept {
  std::array<TickContactPoint, kToolPlaces> points;
  for (std::size_t p = 0; p < places_.size(); ++p) points[Slot(p)] = places_[p].contact_point();
  return points;
}

}  // namespace hpdm
