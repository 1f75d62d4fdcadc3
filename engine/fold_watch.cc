#include "engine/fold_watch.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>

namespace hpdm {
namespace {

// |grad u| up to which no point is evaluated.
constexpr double kClear = 0.95;

using Grid = std::array<int, 3>;

int CountAlong(const Lattice& lattice, int axis) { return lattice.basis().axis(axis).count(); }

// Distance of neighbouring control points along an axis, m.
double Spacing(const Lattice& lattice, int axis) {
  return lattice.box().lengths[axis] * lattice.basis().axis(axis).spacing();
}

// Grid indices of the first function that is not zero at a point: one for each cell.
Grid CellOf(const Lattice& lattice, const Vector3d& p_W) {
  const Vector3d c = lattice.box().ToUnit(p_W);
  Grid cell;
  for (int d = 0; d < 3; ++d) {
    const UnivariateBasis& basis = lattice.basis().axis(d);
    cell[d] = std::clamp(static_cast<int>(c[d] * basis.cells()), 0, basis.cells() - 1);
  }
  return cell;
}

// Column of a function, -1 for none.
int ColumnAt(const Lattice& lattice, const Grid& at) {
  for (int d = 0; d < 3; ++d) {
    if (at[d] < 0 || at[d] >= CountAlong(lattice, d)) return -1;
  }
  return lattice.Column(lattice.basis().Index(at[0], at[1], at[2]));
}

template <typename Pair>
double LargestDifference2(const std::vector<Pair>& pairs, const Points& U) {
  double largest = 0;
  for (const Pair& pair : pairs) {
    largest = std::max(largest, (U.row(pair.b) - U.row(pair.a)).squaredNorm());
  }
  return largest;
}

}  // namespace

FoldWatch::FoldWatch(const Lattice& lattice, const Lattice* finer, const Quadrature& tissue)
    : lattice_(lattice) {
  if (finer != nullptr) finer_.emplace(*finer);
  std::map<Grid, std::vector<Eigen::Index>> points_of;
  for (Eigen::Index q = 0; q < tissue.points.rows(); ++q) {
    points_of[CellOf(lattice, tissue.points.row(q).transpose())].push_back(q);
  }
  // Neighbours along each axis among the grid points first .. first + size - 1.
  const auto pairs_in = [this](const Grid& first, const Grid& size) {
    Pairs pairs;
    Grid at;
    for (int axis = 0; axis < 3; ++axis) {
      for (at[0] = first[0]; at[0] < first[0] + size[0]; ++at[0]) {
        for (at[1] = first[1]; at[1] < first[1] + size[1]; ++at[1]) {
          for (at[2] = first[2]; at[2] < first[2] + size[2]; ++at[2]) {
            if (at[axis] + 1 == first[axis] + size[axis]) continue;
            Grid next = at;
            ++next[axis];
            const int a = ColumnAt(lattice_, at), b = ColumnAt(lattice_, next);
            if (a >= 0 && b >= 0) pairs[axis].push_back({a, b});
          }
        }
      }
    }
    return pairs;
  };
  pairs_ =
      pairs_in({0, 0, 0}, {CountAlong(lattice, 0), CountAlong(lattice, 1), CountAlong(lattice, 2)});
  points_.resize(tissue.points.rows(), 3);
  weights_.resize(tissue.weights.size());
  Eigen::Index next = 0;
  for (const auto& [cell, members] : points_of) {
    const Eigen::Index begin = next;
    for (const Eigen::Index q : members) {
      points_.row(next) = tissue.points.row(q);
      weights_[next++] = tissue.weights[q];
    }
    const TensorBasis& basis = lattice.basis();
    cells_.push_back({begin, next,
                      pairs_in(cell, {basis.axis(0).support(), basis.axis(1).support(),
                                      basis.axis(2).support()})});
  }
}

double FoldWatch::FoldedShare(const ActiveFunctions& active, const Points& U) const {
  const Vector3d local = LocalSlopes(active, U);
  const auto clear = [&](const Pairs& pairs) {
    Vector3d slopes = local;
    for (int axis = 0; axis < 3; ++axis) {
      slopes[axis] += std::sqrt(LargestDifference2(pairs[axis], U)) / Spacing(lattice_, axis);
    }
    return slopes.squaredNorm() < kClear * kClear;
  };
  if (clear(pairs_)) return 0;
  double folded = 0;
  for (const Cell& cell : cells_) {
    if (clear(cell.pairs)) continue;
    for (Eigen::Index q = cell.begin; q < cell.end; ++q) {
      if (!(Determinant(q, active, U) > 0)) folded += weights_[q];
    }
  }
  return folded / weights_.sum();
}

FoldWatch::Folds FoldWatch::EvaluateAll(const ActiveFunctions& active, const Points& U) const {
  Folds folds;
  for (Eigen::Index q = 0; q < points_.rows(); ++q) {
    const double determinant = Determinant(q, active, U);
    folds.least = std::min(folds.least, determinant);
    if (!(determinant > 0)) folds.share += weights_[q];
  }
  folds.share /= weights_.sum();
  return folds;
}

// The largest difference of neighbouring local functions along each axis over their spacing; those
// that are not in use are zero.
Vector3d FoldWatch::LocalSlopes(const ActiveFunctions& active, const Points& U) const {
  Vector3d slopes = Vector3d::Zero();
  if (!finer_) return slopes;
  const int ny = CountAlong(*finer_, 1), nz = CountAlong(*finer_, 2);
  const auto n = U.rows() - active.slots();
  const auto displacement = [&](const Grid& at) -> Eigen::RowVector3d {
    const int column = ColumnAt(*finer_, at);
    const int slot = column < 0 ? -1 : active.Slot(column);
    return slot < 0 ? Eigen::RowVector3d::Zero() : Eigen::RowVector3d(U.row(n + slot));
  };
  for (int slot = 0; slot < active.slots(); ++slot) {
    if (active.Function(slot) < 0) continue;
    const int index = finer_->kept()[active.Function(slot)];
    const Grid at = {index / (ny * nz), index / nz % ny, index % nz};
    for (int axis = 0; axis < 3; ++axis) {
      for (const int step : {-1, 1}) {
        Grid next = at;
        next[axis] += step;
        const double difference = (displacement(next) - U.row(n + slot)).norm();
        slopes[axis] = std::max(slopes[axis], difference / Spacing(*finer_, axis));
      }
    }
  }
  return slopes;
}

double FoldWatch::Determinant(Eigen::Index q, const ActiveFunctions& active,
                              const Points& U) const {
  const Vector3d p = points_.row(q);
  Matrix3d F = Matrix3d::Identity();
  lattice_.ForEachGradient(p, [&](int column, const Vector3d& gradient) {
    F += U.row(column).transpose() * gradient.transpose();
  });
  if (finer_) {
    const auto n = U.rows() - active.slots();
    finer_->ForEachGradient(p, [&](int candidate, const Vector3d& gradient) {
      const int slot = active.Slot(candidate);
      if (slot >= 0) F += U.row(n + slot).transpose() * gradient.transpose();
    });
  }
  return F.determinant();
}

}  // namespace hpdm
