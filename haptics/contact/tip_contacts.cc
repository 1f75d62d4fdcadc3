#include "haptics/contact/tip_contacts.h"

#include <algorithm>

namespace hpdm {

TipContacts::TipContacts(double period) { places_.fill(HapticContact(period)); }

void TipContacts::SetPatches(const ToolPatches& patches) noexcept {
  for (std::size_t p = 0; p < places_.size(); ++p) places_[p].SetPatch(patches.places[p]);
}

void TipContacts::ClearPatches() noexcept {
  for (HapticContact& place : places_) place.ClearPatch();
}

void TipContacts::Locate(const TipPose& tip) noexcept {
  for (HapticContact& place : places_) place.Locate(tip);
}

void TipContacts::Solve(TipContacts* tip) noexcept {
  for (HapticContact& place : tip->places_) HapticContact::Solve(&place);
  tip->SumUp();
}

void TipContacts::Solve(TipContacts* a, TipContacts* c) noexcept {
  for (HapticContact& place : a->places_) {
    HapticContact* const other = c->OnOrgan(place.organ());
    if (other == nullptr) {
      HapticContact::Solve(&place);
    } else {
      HapticContact::Solve(&place, other);
    }
  }
  for (HapticContact& place : c->places_) {
    if (a->OnOrgan(place.organ()) == nullptr) HapticContact::Solve(&place);
  }
  a->SumUp();
  c->SumUp();
}

// Returns the contact with an organ's patch; nullptr if there is none.
HapticContact* TipContacts::OnOrgan(int organ) {
  if (organ < 0) return nullptr;
  const auto found = std::find_if(places_.begin(), places_.end(),
                                  [organ](const HapticContact& p) { return p.organ() == organ; });
  return found == places_.end() ? nullptr : &*found;
}

void TipContacts::SumUp() {
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

std::array<TickContactPoint, kMaxPlaces> TipContacts::contact_points() const noexcept {
  std::array<TickContactPoint, kMaxPlaces> points;
  for (std::size_t p = 0; p < places_.size(); ++p) points[p] = places_[p].contact_point();
  return points;
}

}  // namespace hpdm
