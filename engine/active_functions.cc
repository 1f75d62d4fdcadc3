#include "engine/active_functions.h"

#include <algorithm>

namespace hpdm {

void ActiveFunctions::Follow(const Points& centres, std::span<const Vector3d> points,
                             int per_point) {
  std::fill(wanted_.begin(), wanted_.end(), false);
  const int count = std::min(per_point, static_cast<int>(order_.size()));
  int free = slots();
  for (const Vector3d& p : points) {
    for (std::size_t a = 0; a < order_.size(); ++a) {
      const auto row = static_cast<Eigen::Index>(a);
      order_[a] = {(centres.row(row).transpose() - p).squaredNorm(), static_cast<int>(a)};
    }
    // Ties are broken by the index, so that equal contacts take equal functions.
    if (count < static_cast<int>(order_.size())) {
      std::nth_element(order_.begin(), order_.begin() + count, order_.end());
    }
    for (int i = 0; i < count && free > 0; ++i) {
      if (wanted_[order_[i].second]) continue;
      wanted_[order_[i].second] = true;
      --free;
    }
  }
  for (int s = 0; s < slots(); ++s) {
    changed_[s] = function_[s] >= 0 && !wanted_[function_[s]];
    if (!changed_[s]) continue;
    slot_[function_[s]] = -1;
    function_[s] = -1;
  }
  int s = 0;
  for (int a = 0; a < static_cast<int>(wanted_.size()); ++a) {
    if (!wanted_[a] || slot_[a] >= 0) continue;
    while (function_[s] >= 0) ++s;
    function_[s] = a;
    slot_[a] = s;
    changed_[s] = true;
  }
}

}  // namespace hpdm
