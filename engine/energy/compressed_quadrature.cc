#include "engine/energy/compressed_quadrature.h"

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include "engine/tissue/moment_compression.h"

namespace hpdm {
namespace {

std::vector<int> FunctionsAt(const Lattice& lattice, const Lattice* finer, const Vector3d& p_W) {
  std::vector<int> functions;
  const auto add = [&](int column, double) { functions.push_back(column); };
  lattice.ForEachFunction(p_W, add);
  functions.push_back(-1);
  if (finer != nullptr) finer->ForEachFunction(p_W, add);
  return functions;
}

// Moments are best conditioned within [-1, 1]^3.
void CompressGroup(int degree, Points* points, Eigen::VectorXd* weights) {
  const Eigen::RowVector3d least = points->colwise().minCoeff();
  const Eigen::RowVector3d middle = (least + points->colwise().maxCoeff()) / 2;
  const Eigen::RowVector3d half =
      (middle - least).cwiseMax(1e-9 * (middle - least).maxCoeff()).cwiseMax(1e-300);
  points->rowwise() -= middle;
  points->array().rowwise() /= half.array();
  CompressMoments(degree, points, weights);
  points->array().rowwise() *= half.array();
  points->rowwise() += middle;
}

Quadrature CompressedByLevel(const Lattice& lattice, const Lattice* finer, const Quadrature& tissue,
                             int degree) {
  // The finest level with a function at the point, the cell there, the functions.
  std::map<std::vector<int>, std::vector<Eigen::Index>> groups;
  for (Eigen::Index q = 0; q < tissue.weights.size(); ++q) {
    const Vector3d p = tissue.points.row(q);
    const Vector3d c = lattice.box().ToUnit(p);
    std::vector<int> key = FunctionsAt(lattice, finer, p);
    const auto finest = std::max_element(key.begin(), std::find(key.begin(), key.end(), -1));
    std::size_t level = 0;  // 0: the lattice itself
    while (level < lattice.levels().size() && *finest >= lattice.FirstColumn(level)) ++level;
    const bool local = finer != nullptr && key.back() >= 0;
    std::array<int, 3> cells, place;
    for (int d = 0; d < 3; ++d) {
      const Lattice& at = level == 0 ? lattice : lattice.levels()[level - 1];
      cells[d] = at.basis().axis(d).cells();
      if (local) cells[d] = std::lcm(cells[d], finer->basis().axis(d).cells());
      place[d] = std::clamp(static_cast<int>(c[d] * cells[d]), 0, cells[d] - 1);
    }
    // The place first: groups follow each other along the lattice.
    key.insert(key.begin(), {cells[0], place[0], place[1], place[2]});
    groups[std::move(key)].push_back(q);
  }
  std::vector<Points> points;
  std::vector<Eigen::VectorXd> weights;
  Eigen::Index count = 0;
  for (const auto& [key, members] : groups) {
    points.emplace_back(tissue.points(members, Eigen::all));
    weights.emplace_back(tissue.weights(members));
    CompressGroup(degree, &points.back(), &weights.back());
    count += weights.back().size();
  }
  Quadrature few{Points(count, 3), Eigen::VectorXd(count)};
  Eigen::Index kept = 0;
  for (std::size_t g = 0; g < points.size(); ++g) {
    few.points.middleRows(kept, points[g].rows()) = points[g];
    few.weights.segment(kept, weights[g].size()) = weights[g];
    kept += weights[g].size();
  }
  return few;
}

}  // namespace

Quadrature CompressedQuadrature(const Lattice& lattice, const Lattice* finer,
                                const Quadrature& tissue, int degree) {
  if (!lattice.levels().empty()) return CompressedByLevel(lattice, finer, tissue, degree);
  const Eigen::Index count = tissue.weights.size();
  Quadrature few{Points(count, 3), Eigen::VectorXd(count)};
  Eigen::Index kept = 0;
  std::vector<int> functions = count > 0
                                   ? FunctionsAt(lattice, finer, tissue.points.row(0).transpose())
                                   : std::vector<int>();
  for (Eigen::Index begin = 0, end = 0; begin < count; begin = end) {
    std::vector<int> next = functions;
    while (end < count && next == functions) {
      if (++end < count) next = FunctionsAt(lattice, finer, tissue.points.row(end).transpose());
    }
    functions = std::move(next);
    Points points = tissue.points.middleRows(begin, end - begin);
    Eigen::VectorXd weights = tissue.weights.segment(begin, end - begin);
    CompressGroup(degree, &points, &weights);
    few.points.middleRows(kept, points.rows()) = points;
    few.weights.segment(kept, weights.size()) = weights;
    kept += weights.size();
  }
  few.points.conservativeResize(kept, 3);
  few.weights.conservativeResize(kept);
  return few;
}

}  // namespace hpdm
