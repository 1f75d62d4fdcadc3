#pragma once

#include <algorithm>
#include <tuple>
#include <vector>

#include "engine/base/types.h"

namespace hpdm {

/// One side of one triangle, as the undirected edge low < high.
struct EdgeUse {
  int low = 0;
  int high = 0;
  int triangle = 0;
  int opposite = 0;     ///< Corner (0..2) of the triangle opposite to the side.
  bool forward = true;  ///< The triangle runs along the side from low to high.
};

/// Lists the sides of all triangles, sorted so that the uses of an edge follow each other. Sides
/// between equal corners are left out; otherwise there are 3F entries. Two uses of an edge are
/// consistently oriented if they run in opposite directions.
inline std::vector<EdgeUse> SortedEdgeUses(const Triangles& triangles) {
  std::vector<EdgeUse> uses;
  uses.reserve(static_cast<std::size_t>(3 * triangles.rows()));
  for (int t = 0; t < triangles.rows(); ++t) {
    for (int side = 0; side < 3; ++side) {
      const int from = triangles(t, side), to = triangles(t, (side + 1) % 3);
      if (from == to) continue;
      uses.push_back({std::min(from, to), std::max(from, to), t, (side + 2) % 3, from < to});
    }
  }
  std::sort(uses.begin(), uses.end(), [](const EdgeUse& a, const EdgeUse& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  });
  return uses;
}

/// Calls visit(first, last) with the range of uses of each edge, in sorted order.
template <typename Visit>
void ForEachEdge(const std::vector<EdgeUse>& uses, Visit visit) {
  for (auto first = uses.begin(); first != uses.end();) {
    auto last = first;
    while (last != uses.end() && last->low == first->low && last->high == first->high) ++last;
    visit(first, last);
    first = last;
  }
}

/// Union-find over the integers 0..count-1.
class DisjointSets {
 public:
  explicit DisjointSets(int count) : parent_(static_cast<std::size_t>(count)) {
    for (int i = 0; i < count; ++i) parent_[static_cast<std::size_t>(i)] = i;
  }
  int Find(int i) {
    while (parent(i) != i) {
      parent(i) = parent(parent(i));
      i = parent(i);
    }
    return i;
  }
  /// Keeps the smaller representative, so the result does not depend on the order of merges.
  void Merge(int i, int j) {
    i = Find(i);
    j = Find(j);
    parent(std::max(i, j)) = std::min(i, j);
  }

 private:
  int& parent(int i) { return parent_[static_cast<std::size_t>(i)]; }
  std::vector<int> parent_;
};

}  // namespace hpdm
