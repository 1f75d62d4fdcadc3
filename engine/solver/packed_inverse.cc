#include "engine/solver/packed_inverse.h"

#include <algorithm>
#include <cstring>

#include "engine/base/check.h"

namespace hpdm {
namespace {

constexpr Eigen::Index kTile = 8;  // rows and columns
constexpr Eigen::Index kTileSize = kTile * kTile;

#define HPDM_INLINE [[gnu::always_inline]] inline
using Vector16 = double __attribute__((vector_size(16)));
using Vector32 = double __attribute__((vector_size(32)));
using Vector64 = double __attribute__((vector_size(64)));

// Written out, since GCC 12 makes half as many conversions of it as of __builtin_convertvector.
HPDM_INLINE void Widen(const float* x, Vector16* to) { *to = Vector16{x[0], x[1]}; }
HPDM_INLINE void Widen(const float* x, Vector32* to) { *to = Vector32{x[0], x[1], x[2], x[3]}; }
HPDM_INLINE void Widen(const float* x, Vector64* to) {
  *to = Vector64{x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7]};
}

template <typename Vector>
HPDM_INLINE void Read(const double* from, Vector* to) {
  std::memcpy(to, from, sizeof *to);
}
template <typename Vector>
HPDM_INLINE void Write(const Vector& from, double* to) {
  std::memcpy(to, &from, sizeof from);
}

// y += A x for the panels' tiles. A tile below the diagonal serves its transpose as well. Takes as
// many rows of a tile at a time as a vector has lanes.
template <typename Vector>
HPDM_INLINE void MultiplyTiles(const float* tiles, Eigen::Index panels, const double* x,
                               double* y) {
  constexpr Eigen::Index kLanes = sizeof(Vector) / sizeof(double);
  for (Eigen::Index p = 0; p < panels; ++p) {
    const double* const x_p = x + kTile * p;
    double* const y_p = y + kTile * p;
    double across[kTile][kTile];  // of each column, by the row within the tile
    Vector sum, column, x_r;
    for (Eigen::Index lane = 0; lane < kTile; lane += kLanes) {
      const float* tile = tiles + lane;
      Read(y_p + lane, &sum);
      for (Eigen::Index k = 0; k < kTile; ++k) {
        Widen(tile + kTile * k, &column);
        sum += column * x_p[k];
      }
      Write(sum, y_p + lane);
      tile += kTileSize;
      Vector of_column[kTile] = {};
      for (Eigen::Index r = p + 1; r < panels; ++r, tile += kTileSize) {
        Read(x + kTile * r + lane, &x_r);
        Read(y + kTile * r + lane, &sum);
#pragma GCC unroll 8  // else the sums stay in memory
        for (int k = 0; k < kTile; ++k) {
          Widen(tile + kTile * k, &column);
          sum += column * x_p[k];
          of_column[k] += column * x_r;
        }
        Write(sum, y + kTile * r + lane);
      }
      for (int k = 0; k < kTile; ++k) Write(of_column[k], &across[k][lane]);
    }
    for (int k = 0; k < kTile; ++k) {  // always in the same order
      const double* const s = across[k];
      y_p[k] += ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]));
    }
    tiles += kTileSize * (panels - p);
  }
}

void MultiplyNarrow(const float* tiles, Eigen::Index panels, const double* x, double* y) {
  MultiplyTiles<Vector16>(tiles, panels, x, y);
}
#if defined(__x86_64__)
[[gnu::target("avx2")]] void MultiplyWide(const float* tiles, Eigen::Index panels, const double* x,
                                          double* y) {
  MultiplyTiles<Vector32>(tiles, panels, x, y);
}
[[gnu::target("avx512f")]] void MultiplyWidest(const float* tiles, Eigen::Index panels,
                                               const double* x, double* y) {
  MultiplyTiles<Vector64>(tiles, panels, x, y);
}
#endif

PackedInverse::Kernel KernelFor(VectorWidth width) {
#if defined(__x86_64__)
  if (width == VectorWidth::k64Bytes) return &MultiplyWidest;
  if (width == VectorWidth::k32Bytes) return &MultiplyWide;
#endif
  static_cast<void>(width);
  return &MultiplyNarrow;
}

Eigen::Index Padded(Eigen::Index size) { return (size + kTile - 1) / kTile * kTile; }

}  // namespace

PackedInverse::Workspace::Workspace(Eigen::Index size)
    : x_(static_cast<std::size_t>(Padded(size))), y_(x_.size()) {}

PackedInverse::PackedInverse(const Eigen::MatrixXd& A, VectorWidth width)
    : size_(A.rows()), scale_(A.diagonal().cwiseSqrt()), multiply_(KernelFor(width)) {
  const Eigen::Index panels = Padded(size_) / kTile;
  tiles_.reserve(static_cast<std::size_t>(kTileSize * panels * (panels + 1) / 2));
  for (Eigen::Index p = 0; p < panels; ++p) {
    for (Eigen::Index r = p; r < panels; ++r) {
      for (Eigen::Index column = kTile * p; column < kTile * (p + 1); ++column) {
        for (Eigen::Index row = kTile * r; row < kTile * (r + 1); ++row) {
          const bool inside = row < size_ && column < size_;
          // The lower triangle of a tile on the diagonal, too.
          const Eigen::Index i = std::max(row, column), j = std::min(row, column);
          tiles_.push_back(inside ? static_cast<float>(A(i, j) / (scale_[i] * scale_[j])) : 0.0F);
        }
      }
    }
  }
}

void PackedInverse::Multiply(const Eigen::Ref<const Eigen::VectorXd>& x, Workspace* workspace,
                             Eigen::Ref<Eigen::VectorXd> y) const {
  HPDM_CHECK(x.size() == size_ && y.size() == size_);
  Eigen::Map<Eigen::VectorXd> scaled(workspace->x_.data(), size_), sum(workspace->y_.data(), size_);
  scaled = x.cwiseProduct(scale_);
  std::fill(workspace->y_.begin(), workspace->y_.end(), 0.0);
  multiply_(tiles_.data(), Padded(size_) / kTile, workspace->x_.data(), workspace->y_.data());
  y = sum.cwiseProduct(scale_);
}

}  // namespace hpdm
