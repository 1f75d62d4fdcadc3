#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tools/chart/chart_point.h"
#include "tools/shared/static_case.h"

namespace hpdm {

/// Models of one kind from coarse to fine: an organ's options but for the number of cells.
struct ChartFamily {
  OrganModelType model = OrganModelType::kHpdm;
  EnergyOptions energy;
  LatticeOptions lattice;  ///< Its cells are set from `sizes`; Bernstein: its degree.
  std::vector<int> sizes;
};

/// The families that the chart compares; `quick`: a few of each kind.
std::vector<ChartFamily> ChartFamilies(bool quick);

struct ChartSweep {
  std::vector<ChartPoint> points;
  std::vector<std::string> remarks;  ///< What was left out and why, one line each.
};

/// Measures every family on a case, then the case's own lattice where no family has its cells, and
/// adds what the reference says of linear tetrahedra. A family ends before its finer members when
/// one takes longer than any budget allows. `progress` is told of every point. Single-threaded.
ChartSweep SweepCase(const StaticCase& load_case, const CaseReference& reference,
                     const std::vector<ChartFamily>& families,
                     const std::function<void(const ChartPoint&)>& progress);

}  // namespace hpdm
