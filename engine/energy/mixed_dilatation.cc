#include "engine/energy/mixed_dilatation.h"

#include <Eigen/Cholesky>
#include <array>
#include <utility>
#include <vector>

#include "engine/base/check.h"

namespace hpdm {
namespace {

// Returns the splines of one level, all of them.
Lattice LowerLevel(const Lattice& lattice) {
  LatticeOptions options;
  options.basis = lattice.basis().axis(0).type();
  for (int d = 0; d < 3; ++d) {
    options.degree[d] = lattice.basis().axis(d).degree() - 1;
    options.cells[d] = lattice.basis().axis(d).cells();
  }
  Lattice lower(lattice.box(), options);
  // Found in a cell more on each side, so where no function of the lattice can tell two sides apart,
  // neither can these. With more freedom than the lattice has, the projection would lock.
  if (lattice.split()) lower.SplitByTissue(lattice.pieces(), 1);
  return lower;
}

// Returns for each spline of `lower` whether fewer than half of the functions of `level` whose
// derivatives contain it are in use. They are two along each axis.
std::vector<bool> WithoutParents(const Lattice& lower, const Lattice& level) {
  const TensorBasis &basis = lower.basis(), &parents = level.basis();
  std::vector<bool> without(static_cast<std::size_t>(lower.size()));
  for (std::size_t b = 0; b < without.size(); ++b) {
    const int index = lower.kept()[b];
    const int ny = basis.axis(1).count(), nz = basis.axis(2).count();
    const std::array<int, 3> at = {index / (ny * nz), index / nz % ny, index % nz};
    int used = 0;
    for (int corner = 0; corner < 8; ++corner) {
      used += level.Column(parents.Index(at[0] + (corner & 1), at[1] + (corner >> 1 & 1),
                                         at[2] + (corner >> 2))) >= 0;
    }
    without[b] = used < 4;
  }
  return without;
}

}  // namespace

Lattice LowerDegree(const Lattice& lattice) {
  Lattice lower = LowerLevel(lattice);
  for (const Lattice& level : lattice.levels()) {
    Lattice finer = LowerLevel(level);
    finer.DropControlPoints(WithoutParents(finer, level));
    lower.AddLevel(std::move(finer));
  }
  return lower;
}

CoarserSplines::CoarserSplines(const Lattice& lattice, const Quadrature& tissue) {
  Lattice coarser = LowerDegree(lattice);
  coarser.DropControlPointsWithoutTissue(tissue);
  const WeightMatrix values = coarser.Weights(tissue.points);
  weighted_values_ = tissue.weights.asDiagonal() * values;
  Eigen::MatrixXd mass = Eigen::MatrixXd(WeightMatrix(values.transpose() * weighted_values_));
  mass.diagonal() *= 1 + 1e-8;
  const Eigen::LLT<Eigen::MatrixXd> llt(mass);
  HPDM_CHECK(llt.info() == Eigen::Success);
  factor_ = llt.matrixL();
}

WeightMatrix CoarserSplines::Moments(const WeightMatrix& fields) const {
  return weighted_values_.transpose() * fields;
}

Eigen::MatrixXd CoarserSplines::Project(const WeightMatrix& fields) const {
  Eigen::MatrixXd moments = Eigen::MatrixXd(Moments(fields));
  factor_.triangularView<Eigen::Lower>().solveInPlace(moments);
  return moments;
}

Eigen::MatrixXd ProjectedDilatation(const Lattice& lattice, const Quadrature& tissue) {
  const std::array<WeightMatrix, 3> gradients = lattice.GradientWeights(tissue.points);
  const CoarserSplines splines(lattice, tissue);
  Eigen::MatrixXd projected;
  for (int d = 0; d < 3; ++d) {
    const Eigen::MatrixXd along = splines.Project(gradients[d]);
    if (d == 0) projected.resize(along.rows(), 3 * along.cols());
    for (Eigen::Index a = 0; a < along.cols(); ++a) projected.col(3 * a + d) = along.col(a);
  }
  return projected;
}

}  // namespace hpdm
