#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "engine/base/types.h"

namespace hpdm {

/// The local functions (refinement_basis.h) that an organ has in use: a fixed number of slots, each
/// empty or taken by one function. A function that stays in use keeps its slot. Sized once; one
/// thread; allocates nothing.
///
/// Each function in use has a weight w in (0, 1]: alone it would yield w times as far
/// (schur_complement.h). The weight falls to 0 where the function drops out, so no function enters
/// or leaves with a jump:
///     w = min(1, (1 - d^2 / d_out^2) / kBand) share
/// with d the function's distance from the contact and d_out that of the nearest function that is
/// not taken. w depends on the contact's position only, not on its path.
class ActiveRefinement {
 public:
  /// Fraction of d_out^2 over which functions fade.
  static constexpr double kBand = 0.1;
  static constexpr double kMinWeight = 1e-6;

  ActiveRefinement(int functions, int slots)
      : function_(slots, -1), slot_(functions, -1), wanted_(functions), order_(functions) {}

  int slots() const { return static_cast<int>(function_.size()); }
  /// Returns the number of slots that are not empty.
  int used() const {
    return slots() - static_cast<int>(std::count(function_.begin(), function_.end(), -1));
  }
  /// Returns the function in a slot, or -1.
  int Function(int slot) const { return function_[slot]; }
  /// Returns the slot of a function, or -1.
  int Slot(int function) const { return slot_[function]; }
  /// Returns w of the function in a slot; 1 for an empty slot.
  double Weight(int slot) const { return function_[slot] < 0 ? 1 : wanted_[function_[slot]]; }

  /// Takes the `per_point` functions nearest to each of `points` (m, world, rest) while slots are
  /// free, and releases all others. `centres`: functions x 3, m. `share` (0..1) scales all weights;
  /// 0 releases all functions. O(functions) for each point.
  void ChooseNearest(const Points& centres, std::span<const Vector3d> points, int per_point,
                     double share = 1);

  /// True if the last ChooseNearest() changed the function in the slot.
  bool Changed(int slot) const { return kept_[slot] == 0; }
  /// Returns the weight of the function in a slot over its weight before the last ChooseNearest(),
  /// at most 1; 0 for a slot that changed.
  double Kept(int slot) const { return kept_[slot]; }

 private:
  std::vector<int> function_;
  std::vector<int> slot_;
  std::vector<double> kept_ = std::vector<double>(function_.size(), 1);
  std::vector<double> wanted_;  // weight of each function, 0 if not in use
  std::vector<double> last_ = std::vector<double>(function_.size(), 1);
  std::vector<std::pair<double, int>> order_;
};

}  // namespace hpdm
