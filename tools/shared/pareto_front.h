#pragma once

#include <cstddef>
#include <vector>

namespace hpdm {

/// What a model costs and how far from the truth it is.
struct CostAndError {
  bool counts = true;  ///< May be on a front.
  double step_us = 0;
  double error = 0;
};

/// Indices of those that none beats in both, from fast to slow. Any thread.
std::vector<std::size_t> ParetoFront(const std::vector<CostAndError>& points);

}  // namespace hpdm
