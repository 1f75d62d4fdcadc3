#include "engine/base/add_product.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <vector>

#include "engine/base/check.h"

namespace hpdm {
namespace {

using Eigen::Index;

// Sizes of the blocks that stay in the caches: columns of A and B, rows of A, rows of B.
constexpr Index kColumnsTogether = 256;
constexpr Index kRowsOfA = 192;
constexpr Index kRowsOfB = 1536;
constexpr int kMostRows = 16, kMostColumns = 8;  // of a tile

using Tile = std::array<double, kMostRows * kMostColumns>;

// Computes a tile of A B^T, rows x columns, column-major. Step k of `a` has the tile's rows of A, of
// `b` its rows of B.
using TileProduct = void (*)(Index depth, const double* a, const double* b, double* tile);

struct Kernel {
  TileProduct product = nullptr;
  int rows = 0, columns = 0;
};

#if defined(__x86_64__)
// Vectors of four and eight doubles, an extension of GCC and Clang.
using Four [[gnu::vector_size(32)]] = double;
using Eight [[gnu::vector_size(64)]] = double;

[[gnu::target("avx2")]] void ProductByAvx2(Index depth, const double* a, const double* b,
                                           double* tile) {
  Four sum[4][2] = {};
  for (Index k = 0; k < depth; ++k) {
    Four low, high;
    std::memcpy(&low, a + 8 * k, sizeof low);
    std::memcpy(&high, a + 8 * k + 4, sizeof high);
#pragma GCC unroll 4
    for (int c = 0; c < 4; ++c) {
      sum[c][0] += low * b[4 * k + c];
      sum[c][1] += high * b[4 * k + c];
    }
  }
  std::memcpy(tile, sum, sizeof sum);
}

[[gnu::target("avx512f")]] void ProductByAvx512(Index depth, const double* a, const double* b,
                                                double* tile) {
  Eight sum[8][2] = {};
  for (Index k = 0; k < depth; ++k) {
    Eight low, high;
    std::memcpy(&low, a + 16 * k, sizeof low);
    std::memcpy(&high, a + 16 * k + 8, sizeof high);
#pragma GCC unroll 8
    for (int c = 0; c < 8; ++c) {
      sum[c][0] += low * b[8 * k + c];
      sum[c][1] += high * b[8 * k + c];
    }
  }
  std::memcpy(tile, sum, sizeof sum);
}
#endif

Kernel FastestKernel() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f")) return {&ProductByAvx512, 16, 8};
  if (__builtin_cpu_supports("avx2")) return {&ProductByAvx2, 8, 4};
#endif
  return {};
}

// Copies `rows` rows of M in groups of `group`, each column by column; zeros fill the last group.
void Pack(const Eigen::Ref<const Eigen::MatrixXd>& M, int group, std::vector<double>* packed) {
  packed->resize(static_cast<std::size_t>((M.rows() + group - 1) / group * group * M.cols()));
  double* next = packed->data();
  for (Index first = 0; first < M.rows(); first += group) {
    const Index rows = std::min<Index>(group, M.rows() - first);
    for (Index k = 0; k < M.cols(); ++k, next += group) {
      const double* const from = M.data() + first + k * M.outerStride();
      std::copy(from, from + rows, next);
      std::fill(next + rows, next + group, 0.0);
    }
  }
}

// The block of the product with the rows of A from `row` on and those of B from `column` on.
class BlockProduct {
 public:
  explicit BlockProduct(const Kernel& kernel) : kernel_(kernel) {}

  void TakeA(const Eigen::Ref<const Eigen::MatrixXd>& A) {
    Pack(A, kernel_.rows, &a_);
    rows_ = A.rows();
  }
  void TakeB(const Eigen::Ref<const Eigen::MatrixXd>& B) {
    Pack(B, kernel_.columns, &b_);
    columns_ = B.rows();
    depth_ = B.cols();
  }
  void AddToLower(double factor, Index row, Index column, Eigen::Ref<Eigen::MatrixXd> C) {
    for (Index j = 0; j < columns_; j += kernel_.columns) {
      for (Index i = 0; i < rows_; i += kernel_.rows) {
        if (row + i + kernel_.rows <= column + j) continue;
        Tile tile;
        kernel_.product(depth_, &a_[static_cast<std::size_t>(i * depth_)],
                        &b_[static_cast<std::size_t>(j * depth_)], tile.data());
        const Index tile_rows = std::min<Index>(kernel_.rows, rows_ - i);
        const Index tile_columns = std::min<Index>(kernel_.columns, columns_ - j);
        for (Index c = 0; c < tile_columns; ++c) {
          double* const to = &C.coeffRef(row + i, column + j + c);
          const double* const sum = tile.data() + c * kernel_.rows;
          for (Index r = std::max<Index>(0, column + j + c - row - i); r < tile_rows; ++r) {
            to[r] += factor * sum[r];
          }
        }
      }
    }
  }

 private:
  Kernel kernel_;
  std::vector<double> a_, b_;
  Index rows_ = 0, columns_ = 0, depth_ = 0;
};

}  // namespace

void AddProductToLower(double factor, const Eigen::Ref<const Eigen::MatrixXd>& A,
                       const Eigen::Ref<const Eigen::MatrixXd>& B, Eigen::Ref<Eigen::MatrixXd> C) {
  HPDM_CHECK(A.rows() == C.rows() && B.rows() == C.cols() && A.cols() == B.cols());
  const Kernel kernel = FastestKernel();
  if (kernel.product == nullptr) {
    C.triangularView<Eigen::Lower>() += factor * (A * B.transpose());
    return;
  }
  BlockProduct block(kernel);
  for (Index column = 0; column < B.rows(); column += kRowsOfB) {
    const Index columns = std::min(kRowsOfB, B.rows() - column);
    for (Index k = 0; k < A.cols(); k += kColumnsTogether) {
      const Index depth = std::min(kColumnsTogether, A.cols() - k);
      block.TakeB(B.block(column, k, columns, depth));
      for (Index row = 0; row < A.rows(); row += kRowsOfA) {
        const Index rows = std::min(kRowsOfA, A.rows() - row);
        if (row + rows <= column) continue;
        block.TakeA(A.block(row, k, rows, depth));
        block.AddToLower(factor, row, column, C);
      }
    }
  }
}

}  // namespace hpdm
