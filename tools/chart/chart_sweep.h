#pragma once

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "tools/chart/chart_point.h"
#include "tools/shared/static_case.h"

namespace hpdm {

/// Models of one kind from coarse to fine: an organ's options except the number of cells.
struct ChartFamily {
  std::string group;  ///< One of ChartGroups().
  OrganModelType model = OrganModelType::kHpdm;
  EnergyOptions energy;
  LatticeOptions lattice;  ///< Its cells come from `sizes`; for Bernstein its degree.
  std::vector<int> sizes;
};

/// Returns the names of the groups of families, in the order in which they are measured.
const std::vector<std::string>& ChartGroups();

/// Returns the families that the chart compares, of the groups `only` (empty: all). `quick`: a few of
/// each kind.
std::vector<ChartFamily> ChartFamilies(bool quick, const std::set<std::string>& only = {});

struct ChartSweep {
  std::vector<ChartPoint> points;
  std::vector<std::string> remarks;  ///< Models left out, with the reason, one line each.
};

/// Measures every family on a case, then the case's own lattice if no family has its cells, then
/// adds the reference's results of tetrahedra. A family ends early when a member takes
/// longer than any budget allows. Calls `progress` with every point. Single-threaded.
ChartSweep SweepCase(const StaticCase& load_case, const CaseReference& reference,
                     const std::vector<ChartFamily>& families,
                     const std::function<void(const ChartPoint&)>& progress);

}  // namespace hpdm
