#include "engine/energy/compressed_quadrature.h"

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

}  // namespace

Quadrature CompressedQuadrature(const Lattice& lattice, const Lattice* finer,
                                const Quadrature& tissue, int degree) {
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
