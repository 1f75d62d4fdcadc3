#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "engine/base/types.h"

namespace hpdm {

/// Which of an organ's local functions are in use: a fixed number of slots, each empty or taken by
/// one function of the basis (refinement_basis.h). A function that stays in use keeps its slot.
/// Sized once; one thread; allocates nothing.
///
/// Each function in use has a weight w in (0, 1]: it yields w times what it would alone
/// (schur_complement.h). The weight is 0 where the function would be let go, so that none comes or
/// goes with a jump: with d its distance from the contact and d_out that of the first function that
/// is not taken,
///     w = min(1, (1 - d^2 / d_out^2) / kBand) share.
/// It depends on the contact's place alone, not on the way there.
class ActiveRefinement {
 public:
  /// Share of d_out^2 over which functions fade.
  static constexpr double kBand = 0.1;
  static constexpr double kMinWeight = 1e-6;

  ActiveRefinement(int functions, int slots)
      : function_(slots, -1), slot_(functions, -1), wanted_(functions), order_(functions) {}

  int slots() const { return static_cast<int>(function_.size()); }
  /// Slots that are not empty.
  int used() const {
    return slots() - static_cast<int>(std::count(function_.begin(), function_.end(), -1));
  }
  /// The function in a slot, or -1.
  int Function(int slot) const { return function_[slot]; }
  /// The slot of a function, or -1.
  int Slot(int function) const { return slot_[function]; }
  /// w of the function in a slot; 1 of an empty one.
  double Weight(int slot) const { return function_[slot] < 0 ? 1 : wanted_[function_[slot]]; }

  /// Takes the `per_point` functions nearest to each of `points` (m, world, rest), as long as
  /// there are slots, and lets go of all others. `centres`: functions x 3, m. `share` (0..1): of
  /// all weights; 0 lets go of all. O(functions) a point.
  void ChooseNearest(const Points& centres, std::span<const Vector3d> points, int per_point,
                     double share = 1);

  /// Whether the last ChooseNearest() changed what is in the slot.
  bool Changed(int slot) const { return kept_[slot] == 0; }
  /// Where a function fades: its weight over that before the last ChooseNearest(), at most 1; 0 of
  /// a slot that changed.
  double Kept(int slot) const { return kept_[slot]; }

 private:
  std::vector<int> function_;
  std::vector<int> slot_;
  std::vector<double> kept_ = std::vector<double>(function_.size(), 1);
  std::vector<double> wanted_;  // of each function: its weight, or 0
  std::vector<double> last_ = std::vector<double>(function_.size(), 1);
  std::vector<std::pair<double, int>> order_;
};

}  // namespace hpdm
