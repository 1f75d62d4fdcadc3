#pragma once

#include <string>
#include <vector>

#include "tools/chart/chart_point.h"

namespace hpdm {

/// Step budgets that the chart marks, us: the haptic tick and a frame at 30 Hz.
inline constexpr double kTickBudgetUs = 1e3;
inline constexpr double kFrameBudgetUs = 33e3;

/// Groups the points by case. Solid organs come first and hollow ones last, otherwise in the order
/// of the cases.
std::vector<std::vector<ChartPoint>> ByCase(const std::vector<ChartPoint>& points);

/// Returns a Markdown table. Per case it has the least error within each budget, the least error of
/// few functions, and tetrahedra of about 4,000 nodes: linear of one size, linear and quadratic graded.
std::string ChartMarkdown(const std::vector<ChartPoint>& points, const std::string& machine);

/// Returns the same for a terminal.
std::string ChartText(const std::vector<ChartPoint>& points);

}  // namespace hpdm
