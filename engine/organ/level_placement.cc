#include "engine/organ/level_placement.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <utility>

#include "engine/organ/placement_system.h"

namespace hpdm {
namespace {

constexpr int kPlacementRounds = 6;

// True if a parent of the candidate, on the level before, is in use.
bool MayBeAdded(const std::vector<PlacementLevel>& levels, std::size_t level, std::size_t b) {
  if (level == 0) return true;
  const TensorBasis &basis = levels[level].lattice.basis(),
                    &parents = levels[level - 1].lattice.basis();
  const int index = levels[level].lattice.kept()[b];
  const int ny = basis.axis(1).count(), nz = basis.axis(2).count();
  const std::array<int, 3> at = {index / (ny * nz), index / nz % ny, index % nz};
  std::array<int, 3> low, high;  // 2 j - degree <= i <= 2 j + 1
  for (int d = 0; d < 3; ++d) {
    low[d] = std::max(at[d] / 2, 0);
    high[d] = std::min((at[d] + basis.axis(d).degree()) / 2, parents.axis(d).count() - 1);
  }
  const PlacementLevel& before = levels[level - 1];
  for (int i = low[0]; i <= high[0]; ++i) {
    for (int j = low[1]; j <= high[1]; ++j) {
      for (int k = low[2]; k <= high[2]; ++k) {
        const int column = before.lattice.Column(parents.Index(i, j, k));
        if (column >= 0 && before.used[static_cast<std::size_t>(column)]) return true;
      }
    }
  }
  return false;
}

// Marks the `count` candidates with the largest gains. True if there was one.
bool Choose(int count, const std::vector<Eigen::MatrixXd>& residuals,
            const Eigen::VectorXd& energies, std::vector<PlacementLevel>* levels) {
  struct Gain {
    double value;
    std::size_t level, function;
  };
  std::vector<Gain> gains;
  for (std::size_t level = 0; level < levels->size(); ++level) {
    const PlacementLevel& of = (*levels)[level];
    for (std::size_t b = 0; b < of.used.size(); ++b) {
      if (of.used[b] || of.refused[b] || !MayBeAdded(*levels, level, b)) continue;
      const Eigen::LLT<Matrix3d> own(of.own[b]);
      double gain = 0;
      for (Eigen::Index c = 0; c < energies.size(); ++c) {
        const Vector3d r = residuals[level].block<1, 3>(static_cast<Eigen::Index>(b), 3 * c);
        gain += r.dot(own.solve(r)) / energies[c];
      }
      if (gain > 0) gains.push_back({gain, level, b});
    }
  }
  std::stable_sort(gains.begin(), gains.end(),
                   [](const Gain& a, const Gain& b) { return a.value > b.value; });
  if (gains.size() > static_cast<std::size_t>(count)) {
    gains.resize(static_cast<std::size_t>(count));
  }
  for (const Gain& gain : gains) (*levels)[gain.level].used[gain.function] = true;
  return !gains.empty();
}

}  // namespace

LevelPlacement PlaceLevels(const Lattice& coarse, const OrganOptions& organ,
                           const Quadrature& tissue, const std::vector<Quadrature>& regions,
                           const std::vector<PlacementCase>& cases) {
  PlacementSystem system(coarse, organ, tissue, regions, cases);
  for (int round = 0;; ++round) {
    PlacementSolution solution = system.Solve();
    const std::vector<Eigen::MatrixXd> residuals = system.Residuals(solution);
    const int missing = organ.lattice.adaptive.functions - solution.lattice.size();
    const int count = std::max(1, missing / std::max(1, kPlacementRounds - round));
    if (missing <= 0 || round >= 2 * kPlacementRounds ||
        !Choose(count, residuals, solution.energies, system.levels())) {
      return {std::move(solution.lattice), system.Error(residuals, solution)};
    }
  }
}

}  // namespace hpdm
