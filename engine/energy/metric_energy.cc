#include "engine/energy/metric_energy.h"

#include <map>

#include "engine/base/check.h"

namespace hpdm {
namespace {

// Adds the energy weight/2 |sum_i coefficients[i] U_{columns[i]}|^2.
template <std::size_t N>
void AddSquare(const std::array<int, N>& columns, const std::array<double, N>& coefficients,
               double weight, std::vector<Eigen::Triplet<double>>* entries) {
  for (std::size_t i = 0; i < N; ++i) {
    for (std::size_t j = 0; j < N; ++j) {
      entries->emplace_back(columns[i], columns[j], weight * coefficients[i] * coefficients[j]);
    }
  }
}

}  // namespace

std::vector<std::pair<GridPoint, double>> DifferenceWeights(const Lattice& lattice,
                                                            const Quadrature& tissue,
                                                            const std::vector<int>& axes) {
  std::array<UnivariateBasis, 3> bases = {lattice.basis().axis(0), lattice.basis().axis(1),
                                          lattice.basis().axis(2)};
  for (const int axis : axes) bases[axis] = bases[axis].DerivativeBasis();
  std::array<std::vector<double>, 3> values;
  for (int d = 0; d < 3; ++d) values[d].resize(bases[d].support());
  const int ny = bases[1].count();
  const int nz = bases[2].count();
  std::vector<double> weights(static_cast<std::size_t>(bases[0].count()) * ny * nz, 0.0);
  for (Eigen::Index q = 0; q < tissue.points.rows(); ++q) {
    const Vector3d c = lattice.box().ToUnit(tissue.points.row(q).transpose());
    std::array<int, 3> first;
    for (int d = 0; d < 3; ++d) first[d] = bases[d].Evaluate(c[d], values[d].data());
    for (int i = 0; i < bases[0].support(); ++i) {
      for (int j = 0; j < bases[1].support(); ++j) {
        for (int k = 0; k < bases[2].support(); ++k) {
          weights[((first[0] + i) * ny + first[1] + j) * nz + first[2] + k] +=
              tissue.weights[q] * values[0][i] * values[1][j] * values[2][k];
        }
      }
    }
  }
  std::vector<std::pair<GridPoint, double>> groups;
  GridPoint p;
  std::size_t at = 0;
  for (p[0] = 0; p[0] < bases[0].count(); ++p[0]) {
    for (p[1] = 0; p[1] < ny; ++p[1]) {
      for (p[2] = 0; p[2] < nz; ++p[2], ++at) {
        if (weights[at] > 0) groups.emplace_back(p, weights[at]);
      }
    }
  }
  return groups;
}

ScalarStiffness MetricStiffness(const Lattice& lattice, const Quadrature& tissue, double alpha,
                                double beta) {
  HPDM_CHECK(alpha >= 0 && beta >= 0);
  const TensorBasis& basis = lattice.basis();
  std::vector<Eigen::Triplet<double>> entries;
  for (int axis = 0; axis < 3; ++axis) {
    const double h = lattice.box().lengths[axis] * basis.axis(axis).spacing();
    const auto column = [&](GridPoint p, int step) {
      p[axis] += step;
      return lattice.Column(basis.Index(p[0], p[1], p[2]));
    };
    std::map<GridPoint, double> weights;
    for (const auto& [p, weight] : DifferenceWeights(lattice, tissue, {axis})) {
      weights.emplace(p, weight);
    }
    for (const auto& [p, first] : weights) {
      const int a = column(p, 0), b = column(p, 1);
      if (a < 0 || b < 0) continue;
      AddSquare<2>({a, b}, {-1, 1}, alpha * first / (h * h), &entries);
      GridPoint next = p;
      ++next[axis];
      const auto second = weights.find(next);
      if (beta == 0 || second == weights.end()) continue;
      const int c = column(p, 2);
      if (c < 0) continue;
      AddSquare<3>({a, b, c}, {1, -2, 1}, beta * (first + second->second) / 2 / (h * h * h * h),
                   &entries);
    }
  }
  ScalarStiffness stiffness(lattice.size(), lattice.size());
  stiffness.setFromTriplets(entries.begin(), entries.end());
  return stiffness;
}

Quadrature BoxQuadrature(const OrientedBox& box, const std::array<int, 3>& per_axis) {
  const Eigen::Index total = static_cast<Eigen::Index>(per_axis[0]) * per_axis[1] * per_axis[2];
  Quadrature quadrature{Points(total, 3), Eigen::VectorXd::Constant(
                                              total, box.Volume() / static_cast<double>(total))};
  Eigen::Index row = 0;
  for (int i = 0; i < per_axis[0]; ++i) {
    for (int j = 0; j < per_axis[1]; ++j) {
      for (int k = 0; k < per_axis[2]; ++k) {
        const Vector3d c((i + 0.5) / per_axis[0], (j + 0.5) / per_axis[1], (k + 0.5) / per_axis[2]);
        quadrature.points.row(row++) = box.FromUnit(c);
      }
    }
  }
  return quadrature;
}

}  // namespace hpdm
