#pragma once

#include <cstddef>
#include <vector>

namespace hpdm {

/// Cost of a model and its distance from the reference.
struct CostAndError {
  bool counts = true;  ///< May be on the front.
  double step_us = 0;
  double error = 0;
};

/// Returns the indices of the entries that no other beats in both cost and error, from fast to
/// slow. Any thread.
std::vector<std::size_t> ParetoFront(const std::vector<CostAndError>& points);

}  // namespace hpdm
