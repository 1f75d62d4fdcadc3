#pragma once

#include <array>
#include <vector>

#include "engine/organ_options.h"

namespace hpdm {

/// One-dimensional basis functions on [0, 1] that are non-negative and sum to one:
///  - Bernstein polynomials of any degree p (Eq. 2 and 4, corrected),
///        B_i^p(c) = C(p, i) c^i (1 - c)^(p - i);
///  - uniform B-splines of degree 1 to 3 over equal cells (Hsu, Hughes, Kaufman 1992), of which
///    degree + 1 are non-zero at any point.
class UnivariateBasis {
 public:
  /// Requires degree >= 0 (B-spline: <= 3) and cells >= 1. A Bernstein basis has one cell, whatever
  /// `cells` is.
  UnivariateBasis(BasisType type, int degree, int cells);

  BasisType type() const { return type_; }
  int degree() const { return degree_; }
  int cells() const { return cells_; }
  /// Returns the number of functions: cells + degree (Bernstein: degree + 1).
  int count() const { return cells_ + degree_; }
  /// Returns the number of functions that can be non-zero at one point: degree + 1.
  int support() const { return degree_ + 1; }

  /// Evaluates the functions first .. first + support() - 1 at `c`, clamped to [0, 1]. Returns
  /// first. No allocation.
  int Evaluate(double c, double* values) const;

  /// Evaluates the derivatives d/dc of the same functions. Returns first. Requires degree >= 1. No
  /// allocation.
  int EvaluateDerivatives(double c, double* derivatives) const;

  /// Returns the basis of degree p - 1 whose functions weight the differences of neighbouring
  /// control values in the derivative:
  ///     d/dc sum_i P_i N_i^p = sum_i (P_{i+1} - P_i) / spacing() N_i^{p-1}.
  /// Requires degree >= 1. The functions of degree 0 are the indicators of the cells.
  UnivariateBasis DerivativeBasis() const;

  /// Returns the spacing of control points in units of the box: 1 / cells (Bernstein: 1 / degree).
  double spacing() const;

  /// Returns the Greville abscissa of function i: sum_i Greville(i) N_i(c) = c.
  double Greville(int i) const;

 private:
  BasisType type_;
  int degree_;
  int cells_;
  std::vector<double> binomials_;             // Bernstein: C(degree, i)
  std::vector<double> derivative_binomials_;  // Bernstein: C(degree - 1, i)
};

/// Tensor product of three univariate bases. Function (i, j, k) has index (i ny + j) nz + k.
class TensorBasis {
 public:
  /// Most functions along one axis that are non-zero at a point.
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
