#pragma once

#include <array>

#include "haptics/contact/haptic_contact.h"

namespace hpdm {

/// The contacts of one tool's tip in a tick: one HapticContact for each place of its patches
/// (ToolPatches), all at the same pose. The pose is given, so contacts on different organs do not
/// change each other; the hand feels the sum of their forces. Tips of two tools on one organ are
/// solved together. Haptic thread; wait-free, no allocation, never throws.
class TipContacts {
 public:
  /// `period`: haptic period, s.
  explicit TipContacts(double period = 0.001);

  /// Takes new patches; see HapticContact::SetPatch.
  void SetPatches(const ToolPatches& patches) noexcept;
  /// Removes the patches, and with them the contacts.
  void ClearPatches() noexcept;

  /// Finds the contacts.
  void Locate(const TipPose& tip) noexcept;

  /// Computes the force of one located tip, or of the two tips of a session.
  static void Solve(TipContacts* tip) noexcept;
  static void Solve(TipContacts* a, TipContacts* c) noexcept;

  /// The sums of the reactions, of the walls' parts of them and of their energies. `p_tip_organ_W` is
  /// relative to the organ of the wall that stores most. The other fields are those of the contact
  /// with the largest reaction, or of the grasp.
  const HapticForce& result() const noexcept { return result_; }
  /// The force of one place.
  const HapticForce& result(int place) const noexcept {
    return places_[static_cast<std::size_t>(place)].result();
  }

  /// True if, at the last Solve, the tip touched nothing and its jaws held nothing.
  bool IsFree() const noexcept;

  /// The contacts of this tick, for the deformation loop.
  std::array<TickContactPoint, kMaxPlaces> contact_points() const noexcept;

 private:
  HapticContact* OnOrgan(int organ);
  void SumUp();

  std::array<HapticContact, kMaxPlaces> places_;
  HapticForce result_;
};

}  // namespace hpdm
