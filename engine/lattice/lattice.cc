#include "engine/lattice/lattice.h"

#include <numeric>

#include "engine/base/check.h"

namespace hpdm {

Lattice::Lattice(const OrientedBox& box, const LatticeOptions& options)
    : box_(box), basis_(options), kept_(basis_.count()), column_(basis_.count()) {
  HPDM_CHECK((box.lengths.array() > 0).all());
  std::iota(kept_.begin(), kept_.end(), 0);
  std::iota(column_.begin(), column_.end(), 0);
}

void Lattice::DropControlPointsWithoutTissue(const Quadrature& tissue) {
  const WeightMatrix weights = Weights(tissue.points);
  const Eigen::VectorXd volume = weights.transpose() * tissue.weights;
  const double cell_volume =
      box_.Volume() / (basis_.axis(0).cells() * basis_.axis(1).cells() * basis_.axis(2).cells());
  std::vector<bool> drop(size());
  for (int a = 0; a < size(); ++a) drop[a] = !(volume[a] > 1e-9 * cell_volume);
  DropControlPoints(drop);
}

void Lattice::DropControlPoints(const std::vector<bool>& drop) {
  std::vector<int> kept;
  for (int a = 0; a < size(); ++a) {
    if (!drop[a]) kept.push_back(kept_[a]);
  }
  kept_ = std::move(kept);
  column_.assign(basis_.count(), -1);
  for (int a = 0; a < size(); ++a) column_[kept_[a]] = a;
}

Points Lattice::ControlPoints() const {
  const int ny = basis_.axis(1).count();
  const int nz = basis_.axis(2).count();
  Points points(size(), 3);
  for (int a = 0; a < size(); ++a) {
    const int i = kept_[a] / (ny * nz), j = kept_[a] / nz % ny, k = kept_[a] % nz;
    points.row(a) = box_.FromUnit(Vector3d(basis_.axis(0).Greville(i), basis_.axis(1).Greville(j),
                                           basis_.axis(2).Greville(k)));
  }
  return points;
}

WeightMatrix Lattice::Weights(const Points& points) const {
  WeightMatrix weights(points.rows(), size());
  weights.reserve(Eigen::VectorXi::Constant(points.rows(), std::min(basis_.support(), size())));
  for (Eigen::Index v = 0; v < points.rows(); ++v) {
    ForEachFunction(points.row(v).transpose(),
                    [&](int column, double value) { weights.insert(v, column) = value; });
  }
  weights.makeCompressed();
  return weights;
}

std::array<WeightMatrix, 3> Lattice::GradientWeights(const Points& points) const {
  std::array<WeightMatrix, 3> gradients;
  for (WeightMatrix& gradient : gradients) {
    gradient.resize(points.rows(), size());
    gradient.reserve(Eigen::VectorXi::Constant(points.rows(), std::min(basis_.support(), size())));
  }
  for (Eigen::Index v = 0; v < points.rows(); ++v) {
    ForEachGradient(points.row(v).transpose(), [&](int column, const Vector3d& gradient) {
      for (int d = 0; d < 3; ++d) gradients[d].insert(v, column) = gradient[d];
    });
  }
  for (WeightMatrix& gradient : gradients) gradient.makeCompressed();
  return gradients;
}

OrientedBox BoundingLatticeBox(const Points& vertices, const Matrix3d& axes, double margin) {
  HPDM_CHECK(vertices.rows() > 0);
  const Points local = vertices * axes;
  const Vector3d low = local.colwise().minCoeff().transpose().array() - margin;
  const Vector3d high = local.colwise().maxCoeff().transpose().array() + margin;
  return {.origin_W = axes * low, .axes = axes, .lengths = high - low};
}

}  // namespace hpdm
