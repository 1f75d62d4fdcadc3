#include "engine/lattice/relocation.h"

#include <algorithm>
#include <cstring>
#include <numeric>

#include "engine/base/check.h"

namespace hpdm {
namespace {

constexpr int kBlock = Relocation::kLanes;

// The columns of a row of B, ascending as Eigen keeps them.
struct Columns {
  const int* begin;
  const int* end;
};

Columns ColumnsOf(const WeightMatrix& weights, int row) {
  const int* const inner = weights.innerIndexPtr();
  return {inner + weights.outerIndexPtr()[row], inner + weights.outerIndexPtr()[row + 1]};
}

using Sums = double[3][kBlock];

// Computes sum[d] = sum over the columns of weight x U_d for the kBlock vertices of a block.
void SumPlainly(const double* weights, const int* columns, int count, const double* U, Sums& sum) {
  double x[kBlock] = {}, y[kBlock] = {}, z[kBlock] = {};
  for (int c = 0; c < count; ++c) {
    const double* const w = weights + std::ptrdiff_t{kBlock} * c;
    const double* const u = U + std::ptrdiff_t{3} * columns[c];
    const double ux = u[0], uy = u[1], uz = u[2];
    for (int lane = 0; lane < kBlock; ++lane) {
      x[lane] += w[lane] * ux;
      y[lane] += w[lane] * uy;
      z[lane] += w[lane] * uz;
    }
  }
  std::memcpy(sum[0], x, sizeof x), std::memcpy(sum[1], y, sizeof y);
  std::memcpy(sum[2], z, sizeof z);
}

#if defined(__x86_64__)
// Does the same with vectors of four doubles, an extension of GCC and Clang.
using FourDoubles [[gnu::vector_size(32)]] = double;
static_assert(kBlock * sizeof(double) == 2 * sizeof(FourDoubles));

[[gnu::target("avx2")]] void SumByAvx2(const double* weights, const int* columns, int count,
                                       const double* U, Sums& sum) {
  FourDoubles x0 = {}, x1 = {}, y0 = {}, y1 = {}, z0 = {}, z1 = {};
  for (int c = 0; c < count; ++c) {
    FourDoubles w0, w1;
    std::memcpy(&w0, weights + std::ptrdiff_t{kBlock} * c, sizeof w0);
    std::memcpy(&w1, weights + std::ptrdiff_t{kBlock} * c + kBlock / 2, sizeof w1);
    const double* const u = U + std::ptrdiff_t{3} * columns[c];
    x0 += w0 * u[0], x1 += w1 * u[0];
    y0 += w0 * u[1], y1 += w1 * u[1];
    z0 += w0 * u[2], z1 += w1 * u[2];
  }
  // Six variables instead of an array, which the compiler would keep in memory throughout.
  std::memcpy(sum[0], &x0, sizeof x0), std::memcpy(sum[0] + kBlock / 2, &x1, sizeof x1);
  std::memcpy(sum[1], &y0, sizeof y0), std::memcpy(sum[1] + kBlock / 2, &y1, sizeof y1);
  std::memcpy(sum[2], &z0, sizeof z0), std::memcpy(sum[2] + kBlock / 2, &z1, sizeof z1);
}
#endif

auto* FastestSum() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) return &SumByAvx2;
#endif
  return &SumPlainly;
}

}  // namespace

Relocation::Relocation(const Points& rest, const WeightMatrix& weights)
    : control_points_(weights.cols()),
      vertices_(static_cast<std::size_t>(rest.rows())),
      rest_(rest.rows(), 3),
      sum_block_(FastestSum()) {
  HPDM_CHECK(weights.rows() == rest.rows() && weights.isCompressed());
  std::iota(vertices_.begin(), vertices_.end(), 0);
  std::stable_sort(vertices_.begin(), vertices_.end(), [&](int v, int w) {
    const Columns a = ColumnsOf(weights, v), b = ColumnsOf(weights, w);
    return std::lexicographical_compare(a.begin, a.end, b.begin, b.end);
  });
  const int count = static_cast<int>(vertices_.size());
  for (int first = 0; first < count; first += kLanes) {
    Block block{columns_.size(), 0, std::min(kLanes, count - first)};
    for (int lane = 0; lane < block.vertices; ++lane) {
      const Columns columns = ColumnsOf(weights, vertices_[first + lane]);
      columns_.insert(columns_.end(), columns.begin, columns.end);
    }
    const auto begin = columns_.begin() + static_cast<std::ptrdiff_t>(block.first_column);
    std::sort(begin, columns_.end());
    columns_.erase(std::unique(begin, columns_.end()), columns_.end());
    block.columns = static_cast<int>(columns_.size() - block.first_column);
    weights_.resize(kLanes * columns_.size(), 0);
    for (int lane = 0; lane < block.vertices; ++lane) {
      const int v = vertices_[first + lane];
      rest_.row(first + lane) = rest.row(v);
      for (WeightMatrix::InnerIterator it(weights, v); it; ++it) {
        const auto at = std::lower_bound(begin, columns_.end(), static_cast<int>(it.index()));
        weights_[kLanes * static_cast<std::size_t>(at - columns_.begin()) + lane] = it.value();
      }
    }
    blocks_.push_back(block);
  }
}

void Relocation::Relocate(const Points& U, Points* x) const { Multiply(sum_block_, U, true, x); }

void Relocation::Displace(const Points& U, Points* u) const { Multiply(sum_block_, U, false, u); }

void Relocation::RelocatePlainly(const Points& U, Points* x) const {
  Multiply(&SumPlainly, U, true, x);
}

void Relocation::Multiply(SumBlock sum_block, const Points& U, bool from_rest, Points* x) const {
  HPDM_CHECK(U.rows() >= control_points_ && x->rows() == rest_.rows());
  std::ptrdiff_t at = 0;
  for (const Block& block : blocks_) {
    Sums sum;
    sum_block(weights_.data() + kLanes * block.first_column, columns_.data() + block.first_column,
              block.columns, U.data(), sum);
    for (int lane = 0; lane < block.vertices; ++lane, ++at) {
      double* const p = x->data() + std::ptrdiff_t{3} * vertices_[at];
      const double* const start = rest_.data() + 3 * at;
      for (int d = 0; d < 3; ++d) p[d] = from_rest ? start[d] + sum[d][lane] : sum[d][lane];
    }
  }
}

}  // namespace hpdm
