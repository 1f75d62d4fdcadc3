#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "engine/types.h"

namespace hpdm {

/// Which of an organ's local functions are in use: a fixed number of slots, each empty or taken by
/// one of the candidates (local_functions.h). A function that stays in use keeps its slot. Sized
/// once; one thread; allocates nothing.
class ActiveFunctions {
 public:
  ActiveFunctions(int candidates, int slots)
      : function_(slots, -1), slot_(candidates, -1), wanted_(candidates), order_(candidates) {}

  int slots() const { return static_cast<int>(function_.size()); }
  /// Slots that are not empty.
  int used() const {
    return slots() - static_cast<int>(std::count(function_.begin(), function_.end(), -1));
  }
  /// The candidate in a slot, or -1.
  int Function(int slot) const { return function_[slot]; }
  /// The slot of a candidate, or -1.
  int Slot(int function) const { return slot_[function]; }

  /// Takes the `per_point` candidates nearest to each of `points` (m, world, rest), as long as
  /// there are slots, and lets go of all others. `centres`: candidates x 3, m. O(candidates) a
  /// point.
  void Follow(const Points& centres, std::span<const Vector3d> points, int per_point);

  /// Whether the last Follow() changed what is in the slot.
  bool Changed(int slot) const { return changed_[slot]; }

 private:
  std::vector<int> function_;
  std::vector<int> slot_;
  std::vector<bool> changed_ = std::vector<bool>(function_.size());
  std::vector<bool> wanted_;
  std::vector<std::pair<double, int>> order_;
};

}  // namespace hpdm
