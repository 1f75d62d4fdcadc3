#include "engine/lattice/active_refinement.h"

#include <algorithm>

namespace hpdm {

void ActiveRefinement::ChooseNearest(const Points& centres, std::span<const Vector3d> points,
                                     int per_point, double share) {
  for (int s = 0; s < slots(); ++s) last_[s] = Weight(s);
  std::fill(wanted_.begin(), wanted_.end(), 0);
  const int count = share > 0 ? std::min(per_point, static_cast<int>(order_.size())) : 0;
  const bool some_stay_out = count < static_cast<int>(order_.size());
  int free = slots();
  for (const Vector3d& p : points) {
    for (std::size_t a = 0; a < order_.size(); ++a) {
      const auto row = static_cast<Eigen::Index>(a);
      order_[a] = {(centres.row(row).transpose() - p).squaredNorm(), static_cast<int>(a)};
    }
    // The index breaks ties, so equal contacts take equal functions.
    if (some_stay_out) std::nth_element(order_.begin(), order_.begin() + count, order_.end());
    for (int i = 0; i < count; ++i) {
      double weight = share;
      if (some_stay_out) {
        weight *= std::min(1.0, (1 - order_[i].first / order_[count].first) / kBand);
      }
      double& wanted = wanted_[order_[i].second];
      if (wanted == 0 && free-- <= 0) break;
      wanted = std::max({wanted, weight, kMinWeight});
    }
  }
  for (int s = 0; s < slots(); ++s) {
    const bool goes = function_[s] >= 0 && wanted_[function_[s]] == 0;
    kept_[s] = goes ? 0 : 1;
    if (!goes) continue;
    slot_[function_[s]] = -1;
    function_[s] = -1;
  }
  int s = 0;
  for (int a = 0; a < static_cast<int>(wanted_.size()); ++a) {
    if (wanted_[a] == 0 || slot_[a] >= 0) continue;
    while (function_[s] >= 0) ++s;
    function_[s] = a;
    slot_[a] = s;
    kept_[s] = 0;
  }
  for (int t = 0; t < slots(); ++t) {
    if (kept_[t] > 0) kept_[t] = std::min(1.0, Weight(t) / last_[t]);
  }
}

}  // namespace hpdm
