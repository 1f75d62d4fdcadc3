#pragma once

#include <array>
#include <span>

#include "haptics/contact/haptic_contact.h"

namespace hpdm {

/// The contacts of one tool in a tick: one HapticContact for each place of its patches
/// (ToolPatches), the tip's and the shaft's, all at the same pose. The pose is given, so contacts on
/// different organs do not change each other. Those on one organ do: two tips, of two tools or of one in
/// a notch, are solved together, more of them and a shaft's contacts in rounds. The hand feels the sum
/// of the forces, those of the shaft as they act on the device's axes (OnTip). Its torque about the
/// shaft and across the axes has no actuator. Haptic thread; wait-free, no allocation, never throws.
class TipContacts {
 public:
  /// `period`: haptic period, s.
  explicit TipContacts(double period = 0.001);

  /// Takes new patches; see HapticContact::SetPatch.
  void SetPatches(const ToolPatches& patches) noexcept;
  /// Removes the patches, and with them the contacts.
  void ClearPatches() noexcept;
  /// After a copy: reads a copy of its patches instead.
  void Rebind(const ToolPatches& patches) noexcept;

  /// Finds the contacts. The shaft's part ends above what the tip pressed in the last tick.
  void Locate(const TipPose& tip) noexcept;

  /// Call before Locate of all tools of a session: a contact begins where the others have moved its organ.
  static void StandOnMoved(std::span<TipContacts* const> tools) noexcept;
  /// Computes the forces of all tools of a session, which are located; at most kMaxInstruments.
  static void Solve(std::span<TipContacts* const> tools) noexcept;
  /// The same for one tool.
  static void Solve(TipContacts* tool) noexcept { Solve(std::span(&tool, 1)); }

  /// The sums of the reactions, of the walls' parts of them and of their energies. `p_tip_organ_W` is
  /// relative to the organ of the wall that stores most. The other fields are those of the contact
  /// with the largest reaction, or of the grasp.
  const HapticForce& result() const noexcept { return result_; }
  /// The force of one place.
  const HapticForce& result(int place) const noexcept {
    return places_[static_cast<std::size_t>(place)].result();
  }

  /// True if, at the last Solve, tip and shaft touched nothing and the jaws held nothing.
  bool IsFree() const noexcept;

  /// The contacts of this tick, for the deformation loop.
  std::array<TickContactPoint, kToolPlaces> contact_points() const noexcept;

 private:
  static void FindForces(std::span<TipContacts* const> tools);
  void JoinTips();
  std::span<HapticContact> Tips() { return std::span(places_).first<kMaxPlaces>(); }
  void Finish();

  std::size_t Slot(std::size_t place) const;

  std::array<HapticContact, kToolPlaces> places_;
  /// The shaft's contacts go on in each other's patches: the step may exchange its two places
  /// before it knows of a contact.
  bool shafts_crossed_ = false;
  HapticForce result_;
};

}  // namespace hpdm
