#pragma once

#include <string>
#include <vector>

#include "tools/chart/chart_point.h"

namespace hpdm {

/// The budgets that the chart marks, us: the haptic tick and a frame of 30 Hz.
inline constexpr double kTickBudgetUs = 1e3;
inline constexpr double kFrameBudgetUs = 33e3;

/// The points of each case together, solid organs first and hollow ones last, otherwise in the
/// order in which the cases come.
std::vector<std::vector<ChartPoint>> ByCase(const std::vector<ChartPoint>& points);

/// A table for people: per case the least error within each budget and of few functions, and linear
/// tetrahedra of about 4,000 nodes (even, the nearest there is).
std::string ChartMarkdown(const std::vector<ChartPoint>& points, const std::string& machine);

/// The same for a terminal.
std::string ChartText(const std::vector<ChartPoint>& points);

}  // namespace hpdm
