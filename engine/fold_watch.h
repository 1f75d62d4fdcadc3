#pragma once

#include <array>
#include <optional>
#include <vector>

#include "engine/active_functions.h"
#include "engine/lattice.h"
#include "engine/quadrature.h"

namespace hpdm {

/// Whether an organ's tissue is folded: turned inside out by the lattice map, det(F) <= 0 with
/// F = I + grad u, at its quadrature points.
///
/// Most steps need no point for that. The derivative of u along a lattice axis is a mean of the
/// differences of neighbouring control displacements over their spacing (UnivariateBasis::
/// DerivativeBasis), so |grad u| (Frobenius) is at most the root of the sum over the axes of the
/// largest difference squared; and det(F) > 0 wherever |grad u| < 1. That is looked at for the
/// whole organ, then cell by cell, and only the points of the cells that it does not clear are
/// evaluated. The largest difference of the local functions in use adds to every cell's. Functions
/// that were dropped for want of tissue count as none; a margin of 5 % covers what the tissue has
/// left of them.
///
/// Constant once built; read by any thread, without allocation.
class FoldWatch {
 public:
  /// `tissue`: world, m, m^3. `finer`: of the organ's local functions, or nullptr.
  FoldWatch(const Lattice& lattice, const Lattice* finer, const Quadrature& tissue);

  /// The share (0..1) of the tissue's volume that the control displacements `U` ((n + slots of
  /// `active`) x 3, m, finite) fold.
  double FoldedShare(const ActiveFunctions& active, const Points& U) const;

  /// The same with every point evaluated, and the least det(F) of all: to measure and to test.
  struct Folds {
    double least = 1;
    double share = 0;
  };
  Folds EvaluateAll(const ActiveFunctions& active, const Points& U) const;

  int points() const { return static_cast<int>(points_.rows()); }  ///< Q.

 private:
  struct Pair {
    int a, b;
  };
  // Neighbouring control points along each axis.
  using Pairs = std::array<std::vector<Pair>, 3>;
  // The points [begin, end) of one cell of the lattice, and the pairs among the functions that are
  // not zero in it.
  struct Cell {
    Eigen::Index begin, end;
    Pairs pairs;
  };

  Vector3d LocalSlopes(const ActiveFunctions& active, const Points& U) const;
  double Determinant(Eigen::Index q, const ActiveFunctions& active, const Points& U) const;

  Lattice lattice_;
  std::optional<Lattice> finer_;
  Points points_;            // Q x 3, cell after cell
  Eigen::VectorXd weights_;  // Q, m^3
  Pairs pairs_;              // all
  std::vector<Cell> cells_;
};

}  // namespace hpdm
