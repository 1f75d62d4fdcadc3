#pragma once

#include <array>
#include <optional>
#include <span>

#include "engine/snapshots.h"

namespace hpdm {

struct EnergyTankOptions {
  bool control = true;    ///< False where organs breathe: not all work is the hands'.
  double period = 1e-3;   ///< s, haptic period.
  double reserve = 2e-6;  ///< J that the hands may get beyond what they put in.
  double released = 0.1;  ///< s without a contact after which the organs are at rest.
  double settle = 1;  ///< s, time constant with which a tool that stands still gets its full force.
};

/// Keeps soft tissue from giving the hands more energy than they have put in. The tissue's law can do so
/// where a press moves by centimetres within a deformation step, or where it goes round a small organ: the
/// linear law of the patch is then not that of the shape in the next step, and its force has no potential.
/// PassivityControl damps what hold and delay generate, and limits rigid walls; it does not see this.
///
/// The tank (an energy tank, as in Franken, Stramigioli, Misra, Secchi and Macchelli 2011) belongs to all
/// tools together, since tissue that one tool has moved may push another:
/// 1. E is the work of all hands on the displayed forces since all tools were last free for `released`.
/// 2. U is what the springs of the present contacts store, of tissue and walls (TipEnergy).
/// 3. If U exceeds E, the force of soft tissue is scaled down as it gives energy back. With U_max the
///    largest recent U of the tissue, which returns to U with the time constant `settle`,
///        share = 1 - (1 - (E - U_walls) / U) min(1, max(8 (1 - U / U_max), 2 (1 - 10 E / E_max))),
///    where E_max is the same of E. The second term is for tissue that follows a tip on its way out: U then
///    stays while E is spent. So the force is the tissue's own while a tool presses on, and again once it
///    stands still. On the way out it changes without a step unless E is nearly spent, and springs that store
///    E are left at its end. A force that fades out after its contact stores nothing: its share falls with
///    what is left of E.
/// 4. Where a tip jumps, the tank starts with what the springs store there.
/// 5. A free organ's fall is not in E: what it pushes a hand back by fades out.
/// 6. A contact in which jaws hold is not limited, until all tools are free: jaws do work themselves.
///
/// Haptic thread; wait-free, no allocation, never throws.
class EnergyTank {
 public:
  /// One tool's contacts in a tick.
  struct Press {
    Vector3d p_tip_W = Vector3d::Zero();     ///< m.
    Vector3d reaction_W = Vector3d::Zero();  ///< Force on the hand by tissue and walls, N.
    double tissue_stored = 0;                ///< U of soft tissue, J.
    double wall_stored = 0;                  ///< U of rigid organs' walls, J.
    ContactKind kind = ContactKind::kNone;
  };

  explicit EnergyTank(const EnergyTankOptions& options);

  /// Call once the contacts of a tick are known. Returns the share of soft tissue's force to display.
  double Limit(std::span<const Press> presses) noexcept;
  /// Call after the guard, with the displayed force of each tool, N.
  void Observe(std::span<const Vector3d> forces_W) noexcept;

  /// E, J.
  double energy() const { return energy_; }

 private:
  struct Tool {
    Vector3d p_tip_W = Vector3d::Zero();
    Vector3d moved_W = Vector3d::Zero();  // in this tick
    Vector3d asked_W = Vector3d::Zero();  // of this tick
    Vector3d force_W = Vector3d::Zero();  // displayed in the last tick
  };

  double LargestRecent(double last, double now) const;

  EnergyTankOptions options_;
  double kept_;  // of a difference that falls with the time constant `settle`, in a tick
  std::array<Tool, kMaxInstruments> tools_;
  bool started_ = false;
  bool held_ = false;  // jaws hold, or did in this contact
  double free_ = 0;    // s
  double energy_ = 0, largest_ = 0;
  double most_left_ = 0;  // of E less the walls' energy, recently
  double share_ = 1;      // of the last tick
  double end_share_ = 1;  // while tissue last stored energy
  std::optional<double>
      end_left_;  // E less the walls' energy in the first tick without; none before it
};

}  // namespace hpdm
