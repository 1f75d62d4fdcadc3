#pragma once

#include <array>
#include <vector>

#include "engine/organ_options.h"

namespace hpdm {

/// One-dimensional basis functions on [0, 1] that are non-negative and sum to one: Bernstein
/// polynomials of any degree (Eq. 2 and 4 as corrected: B_i^l(c) = C(l,i) c^i (1-c)^(l-i)), or
/// uniform B-splines of degree 1 to 3 over equal cells (Hsu, Hughes, Kaufman 1992), of which only
/// degree + 1 are non-zero at any point.
class UnivariateBasis {
 public:
  /// A Bernstein basis is one cell. Requires degree >= 1 (B-spline: <= 3), cells >= 1.
  UnivariateBasis(BasisType type, int degree, int cells);

  BasisType type() const { return type_; }
  int degree() const { return degree_; }
  int cells() const { return cells_; }
  /// Number of functions: cells + degree (a Bernstein basis: degree + 1).
  int count() const { return cells_ + degree_; }
  /// Number of functions that can be non-zero at one point: degree + 1.
  int support() const { return degree_ + 1; }

  /// Values of the functions first .. first + support() - 1 at `c`; returns first. `c` is clamped
  /// to [0, 1]. No allocation.
  int Evaluate(double c, double* values) const;

  /// Derivatives d/dc of the same functions; returns first. `c` is clamped to [0, 1]. Requires
  /// degree >= 1. No allocation.
  int EvaluateDerivatives(double c, double* derivatives) const;

  /// The basis of degree - 1 whose functions weight the differences of neighbouring control
  /// values in the derivative: d/dc sum_i P_i N_i^p = sum_i (P_{i+1} - P_i) / spacing() N_i^{p-1}.
  /// Requires degree >= 1; degree 0 is the indicator of a cell.
  UnivariateBasis DerivativeBasis() const;

  /// Spacing of neighbouring control points in units of the box: 1 / cells (Bernstein: 1 / degree).
  double spacing() const;

  /// Greville abscissa of function i: sum_i Greville(i) N_i(c) = c.
  double Greville(int i) const;

 private:
  BasisType type_;
  int degree_;
  int cells_;
  std::vector<double> binomials_;             // Bernstein: C(degree, i)
  std::vector<double> derivative_binomials_;  // Bernstein: C(degree - 1, i)
};

/// Tensor product of three univariate bases; function (i, j, k) has index (i ny + j) nz + k.
class TensorBasis {
 public:
  /// Most functions that are not zero at a point, along one axis.
  static constexpr int kMaxSupport = 64;

  /// Requires degrees below kMaxSupport.
  explicit TensorBasis(const LatticeOptions& options);

  const UnivariateBasis& axis(int d) const { return axes_[d]; }
  int count() const { return axes_[0].count() * axes_[1].count() * axes_[2].count(); }
  int support() const { return axes_[0].support() * axes_[1].support() * axes_[2].support(); }
  int Index(int i, int j, int k) const { return (i * axes_[1].count() + j) * axes_[2].count() + k; }

 private:
  std::array<UnivariateBasis, 3> axes_;
};

}  // namespace hpdm
