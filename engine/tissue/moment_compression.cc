#include "engine/tissue/moment_compression.h"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "engine/base/check.h"

namespace hpdm {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kMaxDegree = 6;

/// Returns the Legendre polynomials P_0..P_degree of t (Bonnet's recursion), which are better
/// conditioned than monomials.
std::array<double, kMaxDegree + 1> Legendre(int degree, double t) {
  std::array<double, kMaxDegree + 1> p{1, t};
  for (std::size_t n = 1; n < static_cast<std::size_t>(degree); ++n) {
    const auto k = static_cast<double>(n);
    p[n + 1] = ((2 * k + 1) * t * p[n] - k * p[n - 1]) / (k + 1);
  }
  return p;
}

/// Returns the M x N matrix whose column q holds the polynomials at point q.
MatrixXd Polynomials(int degree, const Points& points) {
  MatrixXd values(MomentCount(degree), points.rows());
  for (Index q = 0; q < points.rows(); ++q) {
    const auto x = Legendre(degree, points(q, 0)), y = Legendre(degree, points(q, 1)),
               z = Legendre(degree, points(q, 2));
    Index m = 0;
    for (int i = 0; i <= degree; ++i) {
      for (int j = 0; j <= degree; ++j) {
        for (int k = 0; k <= std::min(degree, 2 * degree - i - j); ++k) {
          values(m++, q) = x[static_cast<std::size_t>(i)] * y[static_cast<std::size_t>(j)] *
                           z[static_cast<std::size_t>(k)];
        }
      }
    }
  }
  return values;
}

/// Moves `weights` (> 0) along null vectors of `values` (M x G) until at most rank(values) of them
/// are non-zero. Keeps values * weights, and no weight becomes negative.
void EliminateWeights(const MatrixXd& values, VectorXd* weights) {
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(values.transpose());
  const MatrixXd q = qr.householderQ();
  MatrixXd null = q.rightCols(q.cols() - qr.rank());
  for (Index v = 0; v < null.cols(); ++v) {
    // The first polynomial is 1, so a null vector sums to zero and has entries of both signs.
    Index leaving = -1;
    double step = std::numeric_limits<double>::infinity();
    const double negligible = 1e-12 * null.col(v).lpNorm<Eigen::Infinity>();
    for (Index g = 0; g < weights->size(); ++g) {
      if (null(g, v) > negligible && (*weights)[g] / null(g, v) < step) {
        step = (*weights)[g] / null(g, v);
        leaving = g;
      }
    }
    if (leaving < 0) continue;  // the null vector is rounding only
    *weights = (*weights - step * null.col(v)).cwiseMax(0);
    (*weights)[leaving] = 0;
    for (Index other = v + 1; other < null.cols(); ++other) {
      null.col(other) -= null(leaving, other) / null(leaving, v) * null.col(v);
      null(leaving, other) = 0;
    }
  }
}

}  // namespace

int MomentCount(int degree) {
  return (degree + 1) * (degree + 1) * (degree + 1) - degree * (degree + 1) * (degree + 2) / 6;
}

void CompressMoments(int degree, Points* points, VectorXd* weights) {
  HPDM_CHECK(degree >= 0 && degree <= kMaxDegree && points->rows() == weights->size());
  const Index moments = MomentCount(degree);
  MatrixXd values = Polynomials(degree, *points);
  while (weights->size() > moments) {
    const Index count = weights->size();
    const Index groups = std::min(count, 2 * moments);
    const auto first = [&](Index g) { return g * count / groups; };
    MatrixXd means(moments, groups);
    VectorXd before(groups);
    for (Index g = 0; g < groups; ++g) {
      const Index begin = first(g), size = first(g + 1) - begin;
      before[g] = weights->segment(begin, size).sum();
      means.col(g) = values.middleCols(begin, size) * weights->segment(begin, size) / before[g];
    }
    VectorXd after = before;
    EliminateWeights(means, &after);

    Index kept = 0;
    for (Index g = 0; g < groups; ++g) {
      if (!(after[g] > 0)) continue;
      for (Index q = first(g); q < first(g + 1); ++q, ++kept) {
        (*weights)[kept] = (*weights)[q] * after[g] / before[g];
        points->row(kept) = points->row(q).eval();
        values.col(kept) = values.col(q).eval();
      }
    }
    if (kept == count) break;  // rounding left nothing to eliminate
    weights->conservativeResize(kept);
    points->conservativeResize(kept, 3);
    values.conservativeResize(moments, kept);
  }
}

}  // namespace hpdm
