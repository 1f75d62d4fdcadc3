#include "engine/lattice/basis.h"

#include <algorithm>
#include <cmath>

#include "engine/base/check.h"

namespace hpdm {
namespace {

std::vector<double> Binomials(int degree) {
  std::vector<double> binomials(degree + 1, 1.0);
  for (int i = 1; i <= degree; ++i) binomials[i] = binomials[i - 1] * (degree - i + 1) / i;
  return binomials;
}

// Evaluates the Bernstein polynomials whose binomials are given. Powers are repeated products from
// both ends: free of cancellation, exact at 0 and 1.
void EvaluateBernstein(const std::vector<double>& binomials, double c, double* values) {
  const int degree = static_cast<int>(binomials.size()) - 1;
  double power = 1;
  for (int i = 0; i <= degree; ++i) {
    values[i] = binomials[i] * power;
    power *= c;
  }
  power = 1;
  for (int i = degree; i >= 0; --i) {
    values[i] *= power;
    power *= 1 - c;
  }
}

}  // namespace

UnivariateBasis::UnivariateBasis(BasisType type, int degree, int cells)
    : type_(type), degree_(degree), cells_(type == BasisType::kBernstein ? 1 : cells) {
  HPDM_CHECK(degree >= 0 && cells_ >= 1);
  HPDM_CHECK(type == BasisType::kBernstein || degree <= 3);
  if (type == BasisType::kBernstein) {
    binomials_ = Binomials(degree);
    if (degree > 0) derivative_binomials_ = Binomials(degree - 1);
  }
}

int UnivariateBasis::Evaluate(double c, double* values) const {
  c = std::clamp(c, 0.0, 1.0);
  if (type_ == BasisType::kBernstein) {
    EvaluateBernstein(binomials_, c, values);
    return 0;
  }
  const double scaled = c * cells_;
  const int cell = std::min(static_cast<int>(scaled), cells_ - 1);
  const double t = scaled - cell;
  const double s = 1 - t;
  switch (degree_) {
    case 0:
      values[0] = 1;
      break;
    case 1:
      values[0] = s;
      values[1] = t;
      break;
    case 2:
      values[0] = s * s / 2;
      values[1] = 0.5 + t * s;
      values[2] = t * t / 2;
      break;
    default:
      values[0] = s * s * s / 6;
      values[1] = (4 + t * t * (3 * t - 6)) / 6;
      values[2] = (4 + s * s * (3 * s - 6)) / 6;
      values[3] = t * t * t / 6;
  }
  return cell;
}

int UnivariateBasis::EvaluateDerivatives(double c, double* derivatives) const {
  // N_i^p' = (N_{i-1}^{p-1} - N_i^{p-1}) / h, from the sum at DerivativeBasis() sorted by P_i.
  int first = 0;
  if (type_ == BasisType::kBernstein) {
    EvaluateBernstein(derivative_binomials_, std::clamp(c, 0.0, 1.0), derivatives);
  } else {
    first = DerivativeBasis().Evaluate(c, derivatives);
  }
  derivatives[degree_] = 0;
  for (int i = degree_; i >= 0; --i) {
    const double before = i > 0 ? derivatives[i - 1] : 0;
    derivatives[i] = (before - derivatives[i]) / spacing();
  }
  return first;
}

UnivariateBasis UnivariateBasis::DerivativeBasis() const {
  HPDM_CHECK(degree_ >= 1);
  return UnivariateBasis(type_, degree_ - 1, cells_);
}

double UnivariateBasis::spacing() const {
  return type_ == BasisType::kBernstein ? 1.0 / degree_ : 1.0 / cells_;
}

double UnivariateBasis::Greville(int i) const {
  if (type_ == BasisType::kBernstein) return static_cast<double>(i) / degree_;
  return (i - 0.5 * (degree_ - 1)) / cells_;
}

TensorBasis::TensorBasis(const LatticeOptions& options)
    : axes_{UnivariateBasis(options.basis, options.degree[0], options.cells[0]),
            UnivariateBasis(options.basis, options.degree[1], options.cells[1]),
            UnivariateBasis(options.basis, options.degree[2], options.cells[2])} {
  for (const UnivariateBasis& axis : axes_) HPDM_CHECK(axis.support() <= kMaxSupport);
}

}  // namespace hpdm
