#pragma once

#include <Eigen/SparseCore>
#include <array>
#include <vector>

#include "engine/base/oriented_box.h"
#include "engine/base/quadrature.h"
#include "engine/lattice/basis.h"

namespace hpdm {

/// Rows are points, columns control points: V x n, basis values phi_a(x_v).
using WeightMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// The free-form-deformation lattice of one organ (Eq. 1-5): an oriented box, a tensor basis over
/// it, and the control points that are kept. It maps a rest position X to
///     x = X + sum_a phi_a(X) U_a
/// with control displacements U (n x 3, m, world axes). U = 0 gives the identity, whatever was
/// dropped. Constant once built; read by any thread.
class Lattice {
 public:
  /// Keeps all control points.
  Lattice(const OrientedBox& box, const LatticeOptions& options);

  /// Keeps only the control points whose function has tissue: the integral of phi_a over `tissue`
  /// exceeds 1e-9 of a cell's volume. A function with less has no energy and moves nothing.
  void DropControlPointsWithoutTissue(const Quadrature& tissue);

  /// Drops each kept control point a for which drop[a] is true. The remaining columns are
  /// renumbered.
  void DropControlPoints(const std::vector<bool>& drop);

  const OrientedBox& box() const { return box_; }
  const TensorBasis& basis() const { return basis_; }

  /// Returns n, the number of kept control points.
  int size() const { return static_cast<int>(kept_.size()); }
  /// Returns the grid index (TensorBasis::Index) of each kept control point, n.
  const std::vector<int>& kept() const { return kept_; }
  /// Returns the column of a grid index, or -1 if that control point was dropped.
  int Column(int grid_index) const { return column_[grid_index]; }

  /// Returns the rest positions of the kept control points, n x 3, world, m. They are the Greville
  /// points, so Eq. 4 reproduces the rest shape if nothing is dropped.
  Points ControlPoints() const;

  /// Returns the basis values at `points` (V x 3, world, m): V x n. A row sums to one if no
  /// function that is non-zero at its point was dropped.
  WeightMatrix Weights(const Points& points) const;

  /// Calls f(column, phi_column(p)) for each kept function that can be non-zero at `p_W` (m).
  /// Lattice coordinates outside the box are clamped to it. Any thread, no allocation.
  template <typename Function>
  void ForEachFunction(const Vector3d& p_W, Function&& f) const;

  /// Calls f(column, d phi_column / dx) (1/m, world axes) at `p_W` (m) for the same functions. Any
  /// thread, no allocation.
  template <typename Function>
  void ForEachGradient(const Vector3d& p_W, Function&& f) const;

  /// Returns the gradients of the basis functions at `points` (V x 3, world, m). Element d is V x n
  /// and holds d phi_a / d x_d along the world axis d, 1/m. Rows sum to zero where those of
  /// Weights() sum to one. Set-up only.
  std::array<WeightMatrix, 3> GradientWeights(const Points& points) const;

 private:
  OrientedBox box_;
  TensorBasis basis_;
  std::vector<int> kept_;
  std::vector<int> column_;
};

template <typename Function>
void Lattice::ForEachFunction(const Vector3d& p_W, Function&& f) const {
  const Vector3d c = box_.ToUnit(p_W);
  std::array<std::array<double, TensorBasis::kMaxSupport>, 3> values;
  std::array<int, 3> first;
  for (int d = 0; d < 3; ++d) first[d] = basis_.axis(d).Evaluate(c[d], values[d].data());
  for (int i = 0; i < basis_.axis(0).support(); ++i) {
    for (int j = 0; j < basis_.axis(1).support(); ++j) {
      const double ij = values[0][i] * values[1][j];
      for (int k = 0; k < basis_.axis(2).support(); ++k) {
        const int column = Column(basis_.Index(first[0] + i, first[1] + j, first[2] + k));
        if (column >= 0) f(column, ij * values[2][k]);
      }
    }
  }
}

template <typename Function>
void Lattice::ForEachGradient(const Vector3d& p_W, Function&& f) const {
  const Vector3d c = box_.ToUnit(p_W);
  // d/dx = axes diag(1 / lengths) d/dc, because c = diag(1 / lengths) axes^T (x - origin).
  const Matrix3d to_world = box_.axes * box_.lengths.cwiseInverse().asDiagonal();
  std::array<std::array<double, TensorBasis::kMaxSupport>, 3> values, derivatives;
  std::array<int, 3> first;
  for (int d = 0; d < 3; ++d) {
    first[d] = basis_.axis(d).Evaluate(c[d], values[d].data());
    basis_.axis(d).EvaluateDerivatives(c[d], derivatives[d].data());
  }
  for (int i = 0; i < basis_.axis(0).support(); ++i) {
    for (int j = 0; j < basis_.axis(1).support(); ++j) {
      for (int k = 0; k < basis_.axis(2).support(); ++k) {
        const int column = Column(basis_.Index(first[0] + i, first[1] + j, first[2] + k));
        if (column < 0) continue;
        const Vector3d by_c(derivatives[0][i] * values[1][j] * values[2][k],
                            values[0][i] * derivatives[1][j] * values[2][k],
                            values[0][i] * values[1][j] * derivatives[2][k]);
        f(column, Vector3d(to_world * by_c));
      }
    }
  }
}

/// Returns the box of Eq. 1 around `vertices` (V x 3, world, m). It is parallel to `axes` (columns:
/// unit vectors) and enlarged by `margin` (m) on every side.
OrientedBox BoundingLatticeBox(const Points& vertices, const Matrix3d& axes, double margin);

}  // namespace hpdm
