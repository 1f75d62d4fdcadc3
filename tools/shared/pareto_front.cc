#include "tools/shared/pareto_front.h"

#include <algorithm>

namespace hpdm {

std::vector<std::size_t> ParetoFront(const std::vector<CostAndError>& points) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].counts) order.push_back(i);
  }
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const double first = points[a].step_us, second = points[b].step_us;
    return first != second ? first < second : points[a].error < points[b].error;
  });
  std::vector<std::size_t> front;
  for (const std::size_t i : order) {
    if (front.empty() || points[i].error < points[front.back()].error) front.push_back(i);
  }
  return front;
}

}  // namespace hpdm
