#pragma once

#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "engine/base/oriented_box.h"
#include "engine/base/quadrature.h"
#include "engine/lattice/basis.h"
#include "engine/lattice/tissue_pieces.h"

namespace hpdm {

/// Rows are points, columns control points: V x n, basis values phi_a(x_v).
using WeightMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// The free-form-deformation lattice of one organ (Eq. 1-5): an oriented box, a tensor basis over
/// it, and the control points that are kept. It maps a rest position X to
///     x = X + sum_a phi_a(X) U_a
/// with control displacements U (n x 3, m, world axes). U = 0 gives the identity, whatever was
/// dropped. Constant once built; read by any thread.
///
/// SplitByTissue() gives a function one control point for each connected component of the tissue in
/// its support. Then the columns at a point depend on the tissue there, its Site.
class Lattice {
 public:
  /// Place of a material point in the lattice.
  struct Site {
    Vector3d c;  ///< Lattice coordinates.
    const int* columns =
        nullptr;  ///< Columns (or -1) of the functions that can be non-zero there, in
                  ///< their order of TensorBasis::Index; nullptr: Column() says.
    Vector3d p_W = Vector3d::Zero();     ///< m.
    Vector3d side_W = Vector3d::Zero();  ///< m: the side of a cut on which a point of it lies.
  };

  /// Keeps all control points.
  Lattice(const OrientedBox& box, const LatticeOptions& options);

  /// Keeps only the control points whose function has tissue: the integral of phi_a over `tissue`
  /// exceeds 1e-9 of a cell's volume. A function with less has no energy and moves nothing.
  void DropControlPointsWithoutTissue(const Quadrature& tissue);

  /// Drops each kept control point a for which drop[a] is true. The remaining columns are
  /// renumbered.
  void DropControlPoints(const std::vector<bool>& drop);

  /// Splits the functions by connected tissue: where the tissue in a function's support falls into
  /// several components, each gets a copy of the function, with its own control point. So the sides
  /// of a notch, near walls and the walls of a lumen move independently.
  ///
  /// 1. The copies are phi_a chi with chi = 1 on one component, 0 on the others. phi_a vanishes at the
  ///    support's border, so u stays smooth in the tissue. The copies' sum is phi_a.
  /// 2. A component with less than TissuePieces::kSliver cells of tissue joins the largest one. One
  ///    with less than 1 % of phi_a's integral joins that with most of it, if tissue in a cell around
  ///    the support joins the two.
  /// 3. `beyond`: cells on each side of a support that count as part of it when components are found.
  /// 4. The cells of `pieces` divide those of the lattice, whose basis is B-splines. All control
  ///    points must be kept.
  ///
  /// 5. Pieces that were found with cuts are those of the tissue on each side of these.
  ///
  /// With no copy to make, or more than two a function, the lattice stays as it was. Set-up only.
  void SplitByTissue(std::shared_ptr<const TissuePieces> pieces, int beyond = 0);
  /// Adds the functions phi_a F1 and phi_a F3 of the cuts' fronts (cut_surface.h), so that a crack
  /// which ends in phi_a's support can open:
  ///
  /// 1. They belong to each kept phi_a whose support holds a part of the front, or is cut and ends
  ///    less than a cell behind the front. That keeps the shape continuous while a cut grows.
  /// 2. Their control points follow all others, two by two, at the Greville points of phi_a.
  /// 3. ForEachFunction() and all that stands on it includes them; Column() does not.
  /// 4. Their values do not sum to anything.
  ///
  /// The pieces were found with cuts. Last step of building a lattice; set-up only.
  void AddFrontFunctions();
  /// Returns the number of control points that AddFrontFunctions() has added.
  int front_functions() const { return front_functions_; }
  /// Adds the functions of a finer lattice over the same box: hierarchical splines (Forsey, Bartels
  /// 1988).
  ///
  /// 1. Their control points follow all others, level after level from coarse to fine.
  /// 2. ForEachFunction() and all that stands on it includes them. basis(), kept(), Column() and
  ///    ColumnAt() are those of the coarsest level.
  /// 3. The coarsest functions stay, so these still sum to one. A function that the others span makes
  ///    the stiffness singular: the caller leaves it out.
  ///
  /// `level` has B-splines with a multiple of the cells of the last level and only the functions that
  /// are used. Set-up only.
  void AddLevel(Lattice level);
  /// Returns the finer lattices that AddLevel() has added.
  const std::vector<Lattice>& levels() const { return levels_; }
  /// Returns the column of the first control point of levels()[level].
  int FirstColumn(std::size_t level) const;
  /// Returns the lattice of the finest level.
  const Lattice& Finest() const { return levels_.empty() ? *this : levels_.back(); }
  /// True if SplitByTissue() has split a function.
  bool split() const { return !piece_columns_.empty(); }
  /// Returns what SplitByTissue() was given, or nullptr.
  const std::shared_ptr<const TissuePieces>& pieces() const { return pieces_; }

  const OrientedBox& box() const { return box_; }
  const TensorBasis& basis() const { return basis_; }

  /// Returns n, the number of kept control points of all levels.
  int size() const { return static_cast<int>(kept_.size()) + level_functions_; }
  /// Returns the grid index (TensorBasis::Index) of each kept control point of the coarsest level,
  /// ascending up to those of front functions. The copies of a split function follow each other.
  const std::vector<int>& kept() const { return kept_; }
  /// Returns the column of a grid index, the first one of a split function, or -1 if all its control
  /// points were dropped.
  int Column(int grid_index) const { return column_[grid_index]; }

  /// Returns the rest positions of the kept control points, n x 3, world, m. They are the Greville
  /// points, so Eq. 4 on the coarsest level reproduces the rest shape if nothing is dropped.
  Points ControlPoints() const;

  /// Returns the site of a tissue point (world, m). Coordinates outside the box are clamped to it.
  Site SiteOf(const Vector3d& p_W) const { return SiteOf(p_W, p_W); }
  /// Returns the site of a point on the tissue's surface. `inside_W` (m) is a point inset() deeper in
  /// the tissue, which shows the side of a gap that the surface belongs to.
  Site SiteOf(const Vector3d& p_W, const Vector3d& inside_W) const;
  /// Returns the column (or -1) at a site of the function `local` places behind the function `first`
  /// (TensorBasis::Index of both). `first` must be the first one that can be non-zero there.
  int ColumnAt(const Site& site, const std::array<int, 3>& first,
               const std::array<int, 3>& local) const {
    if (site.columns == nullptr) {
      return Column(basis_.Index(first[0] + local[0], first[1] + local[1], first[2] + local[2]));
    }
    return site
        .columns[(local[0] * basis_.axis(1).support() + local[1]) * basis_.axis(2).support() +
                 local[2]];
  }
  /// Returns the depth (m) of `inside_W` above; 0 if no function is split.
  double inset() const { return inset_; }

  /// Returns the basis values at `points` (V x 3, world, m) in the tissue: V x n. A row sums to one
  /// if no function that is non-zero at its point was dropped.
  WeightMatrix Weights(const Points& points) const { return Weights(points, points); }
  /// Does the same at points of the surface, which lie inset() above `inside` (V x 3, m).
  WeightMatrix Weights(const Points& points, const Points& inside) const;

  /// Calls f(column, phi_column(p)) for each kept function that can be non-zero at `p_W` (m).
  /// Any thread, no allocation.
  template <typename Function>
  void ForEachFunction(const Vector3d& p_W, Function&& f) const {
    ForEachFunction(SiteOf(p_W), f);
  }
  template <typename Function>
  void ForEachFunction(const Site& site, Function&& f) const;

  /// Calls f(column, d phi_column / dx) (1/m, world axes) at `p_W` (m) for the same functions. Any
  /// thread, no allocation.
  template <typename Function>
  void ForEachGradient(const Vector3d& p_W, Function&& f) const {
    ForEachGradient(SiteOf(p_W), f);
  }
  template <typename Function>
  void ForEachGradient(const Site& site, Function&& f) const;

  /// Returns the gradients of the basis functions at `points` (V x 3, world, m). Element d is V x n
  /// and holds d phi_a / d x_d along the world axis d, 1/m. Rows sum to zero where those of
  /// Weights() sum to one. Set-up only.
  std::array<WeightMatrix, 3> GradientWeights(const Points& points) const;

 private:
  struct Front {
    int cut = 0;               // number of the cut
    std::vector<int> columns;  // of each grid index: the first of two, or -1
  };
  // Calls f for each function of this level at the site, front functions included.
  template <typename Function>
  void ForEachOwnFunction(const Site& site, Function&& f) const;
  template <typename Function>
  void ForEachOwnGradient(const Site& site, Function&& f) const;
  template <typename Function>
  void ForEachFrontFunction(const Site& site, const std::array<int, 3>& first, Function&& f) const;
  std::vector<int> FunctionsAtFront(const CutSurface& cut) const;
  double FrontLength() const;  // m: h of F
  double InsetOf(const TissuePieces& pieces) const;
  int FunctionsAtPoint() const;  // at most
  void AddCopies(const std::array<int, 3>& at, const TissuePieces::Components& components,
                 const std::array<int, 3>& finer, std::vector<int>* columns);

  OrientedBox box_;
  TensorBasis basis_;
  std::vector<int> kept_;
  std::vector<int> column_;
  std::shared_ptr<const TissuePieces> pieces_;
  std::vector<int> piece_columns_;  // pieces x basis_.support(), empty without a split function
  double inset_ = 0;                // m
  std::vector<Front> fronts_;
  int front_functions_ = 0;
  std::vector<Lattice> levels_;
  int level_functions_ = 0;
};

template <typename Function>
void Lattice::ForEachFunction(const Site& site, Function&& f) const {
  ForEachOwnFunction(site, f);
  int begin = static_cast<int>(kept_.size());
  for (const Lattice& level : levels_) {
    level.ForEachOwnFunction(level.SiteOf(site.p_W, site.side_W),
                             [&](int column, double value) { f(begin + column, value); });
    begin += level.size();
  }
}

template <typename Function>
void Lattice::ForEachGradient(const Site& site, Function&& f) const {
  ForEachOwnGradient(site, f);
  int begin = static_cast<int>(kept_.size());
  for (const Lattice& level : levels_) {
    level.ForEachOwnGradient(
        level.SiteOf(site.p_W, site.side_W),
        [&](int column, const Vector3d& gradient) { f(begin + column, gradient); });
    begin += level.size();
  }
}

template <typename Function>
void Lattice::ForEachOwnFunction(const Site& site, Function&& f) const {
  const Vector3d& c = site.c;
  const int* next = site.columns;
  std::array<std::array<double, TensorBasis::kMaxSupport>, 3> values;
  std::array<int, 3> first;
  for (int d = 0; d < 3; ++d) first[d] = basis_.axis(d).Evaluate(c[d], values[d].data());
  for (int i = 0; i < basis_.axis(0).support(); ++i) {
    for (int j = 0; j < basis_.axis(1).support(); ++j) {
      const double ij = values[0][i] * values[1][j];
      for (int k = 0; k < basis_.axis(2).support(); ++k) {
        const int column = next != nullptr
                               ? *next++
                               : Column(basis_.Index(first[0] + i, first[1] + j, first[2] + k));
        if (column >= 0) f(column, ij * values[2][k]);
      }
    }
  }
  if (fronts_.empty()) return;
  ForEachFrontFunction(site, first,
                       [&](const std::array<int, 3>& at, int column, const FrontValues& front) {
                         const double phi = values[0][at[0]] * values[1][at[1]] * values[2][at[2]];
                         for (int kind = 0; kind < 2; ++kind)
                           f(column + kind, phi * front.value[kind]);
                       });
}

template <typename Function>
void Lattice::ForEachOwnGradient(const Site& site, Function&& f) const {
  const Vector3d& c = site.c;
  const int* next = site.columns;
  // d/dx = axes diag(1 / lengths) d/dc, because c = diag(1 / lengths) axes^T (x - origin).
  const Matrix3d to_world = box_.axes * box_.lengths.cwiseInverse().asDiagonal();
  std::array<std::array<double, TensorBasis::kMaxSupport>, 3> values, derivatives;
  std::array<int, 3> first;
  for (int d = 0; d < 3; ++d) {
    first[d] = basis_.axis(d).Evaluate(c[d], values[d].data());
    basis_.axis(d).EvaluateDerivatives(c[d], derivatives[d].data());
  }
  const auto by_c = [&](int i, int j, int k) {
    return Vector3d(derivatives[0][i] * values[1][j] * values[2][k],
                    values[0][i] * derivatives[1][j] * values[2][k],
                    values[0][i] * values[1][j] * derivatives[2][k]);
  };
  for (int i = 0; i < basis_.axis(0).support(); ++i) {
    for (int j = 0; j < basis_.axis(1).support(); ++j) {
      for (int k = 0; k < basis_.axis(2).support(); ++k) {
        const int column = next != nullptr
                               ? *next++
                               : Column(basis_.Index(first[0] + i, first[1] + j, first[2] + k));
        if (column >= 0) f(column, Vector3d(to_world * by_c(i, j, k)));
      }
    }
  }
  if (fronts_.empty()) return;
  ForEachFrontFunction(
      site, first, [&](const std::array<int, 3>& at, int column, const FrontValues& front) {
        const double phi = values[0][at[0]] * values[1][at[1]] * values[2][at[2]];
        const Vector3d gradient = to_world * by_c(at[0], at[1], at[2]);
        for (int kind = 0; kind < 2; ++kind) {
          f(column + kind, Vector3d(front.value[kind] * gradient + phi * front.gradient[kind]));
        }
      });
}

// Calls f(place behind `first`, first of two columns, F) for each spline with front functions.
template <typename Function>
void Lattice::ForEachFrontFunction(const Site& site, const std::array<int, 3>& first,
                                   Function&& f) const {
  for (const Front& front : fronts_) {
    std::optional<FrontValues> values;
    std::array<int, 3> at;
    for (at[0] = 0; at[0] < basis_.axis(0).support(); ++at[0]) {
      for (at[1] = 0; at[1] < basis_.axis(1).support(); ++at[1]) {
        for (at[2] = 0; at[2] < basis_.axis(2).support(); ++at[2]) {
          const int column =
              front.columns[basis_.Index(first[0] + at[0], first[1] + at[1], first[2] + at[2])];
          if (column < 0) continue;
          if (!values) {
            values = (*pieces_->cuts())[front.cut].AtFront(site.p_W, site.side_W, FrontLength());
          }
          f(at, column, *values);
        }
      }
    }
  }
}

/// Returns the box of Eq. 1 around `vertices` (V x 3, world, m). It is parallel to `axes` (columns:
/// unit vectors) and enlarged by `margin` (m) on every side.
OrientedBox BoundingLatticeBox(const Points& vertices, const Matrix3d& axes, double margin);

}  // namespace hpdm
