#include "engine/energy/metric_energy.h"

#include <algorithm>
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

std::vector<DifferenceGroup> DifferenceWeights(const Lattice& lattice, const Quadrature& tissue,
                                               const std::vector<int>& axes) {
  HPDM_CHECK(axes.size() == 1 || axes.size() == 2);
  std::array<UnivariateBasis, 3> bases = {lattice.basis().axis(0), lattice.basis().axis(1),
                                          lattice.basis().axis(2)};
  for (const int axis : axes) bases[axis] = bases[axis].DerivativeBasis();
  std::array<std::vector<double>, 3> values;
  for (int d = 0; d < 3; ++d) values[d].resize(bases[d].support());
  const int ny = bases[1].count();
  const int nz = bases[2].count();
  // The groups at each place of the grid: one, or several where functions are split.
  std::vector<std::vector<DifferenceGroup>> groups_at(static_cast<std::size_t>(bases[0].count()) *
                                                      ny * nz);
  for (Eigen::Index q = 0; q < tissue.points.rows(); ++q) {
    const Lattice::Site site = lattice.SiteOf(tissue.points.row(q).transpose());
    std::array<int, 3> first;
    for (int d = 0; d < 3; ++d) first[d] = bases[d].Evaluate(site.c[d], values[d].data());
    for (int i = 0; i < bases[0].support(); ++i) {
      for (int j = 0; j < bases[1].support(); ++j) {
        for (int k = 0; k < bases[2].support(); ++k) {
          DifferenceGroup group{.at = {first[0] + i, first[1] + j, first[2] + k},
                                .columns = {-1, -1, -1, -1}};
          for (std::size_t corner = 0; corner < (std::size_t{1} << axes.size()); ++corner) {
            std::array<int, 3> local = {i, j, k};
            for (std::size_t a = 0; a < axes.size(); ++a) {
              local[axes[a]] += static_cast<int>(corner >> (axes.size() - 1 - a) & 1);
            }
            group.columns[corner] = lattice.ColumnAt(site, first, local);
          }
          std::vector<DifferenceGroup>& known =
              groups_at[(group.at[0] * ny + group.at[1]) * nz + group.at[2]];
          const auto found = std::find_if(
              known.begin(), known.end(),
              [&group](const DifferenceGroup& other) { return other.columns == group.columns; });
          DifferenceGroup& sum = found == known.end() ? known.emplace_back(group) : *found;
          sum.weight += tissue.weights[q] * values[0][i] * values[1][j] * values[2][k];
        }
      }
    }
  }
  std::vector<DifferenceGroup> groups;
  for (const std::vector<DifferenceGroup>& known : groups_at) {
    for (const DifferenceGroup& group : known) {
      if (group.weight > 0) groups.push_back(group);
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
    const std::vector<DifferenceGroup> groups = DifferenceWeights(lattice, tissue, {axis});
    std::multimap<GridPoint, const DifferenceGroup*> at;
    for (const DifferenceGroup& group : groups) at.emplace(group.at, &group);
    for (const DifferenceGroup& group : groups) {
      const int a = group.columns[0], b = group.columns[1];
      if (a < 0 || b < 0) continue;
      AddSquare<2>({a, b}, {-1, 1}, alpha * group.weight / (h * h), &entries);
      if (beta == 0) continue;
      GridPoint next = group.at;
      ++next[axis];
      for (auto [it, end] = at.equal_range(next); it != end; ++it) {
        const DifferenceGroup& second = *it->second;
        const int c = second.columns[1];
        if (second.columns[0] != b || c < 0) continue;
        AddSquare<3>({a, b, c}, {1, -2, 1},
                     beta * (group.weight + second.weight) / 2 / (h * h * h * h), &entries);
      }
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
