#include "engine/base/few_columns.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "engine/base/check.h"

namespace hpdm {
namespace few_columns {
namespace {

using Eigen::Index;

// The loops are written once, for vectors V that the processor has. Each set of functions below,
// compiled for other instructions, contains them. A row is kParts vectors.
#define HPDM_INLINE [[gnu::always_inline]] inline

// Extensions of GCC and Clang.
using Doubles2 [[gnu::vector_size(16)]] = double;
using Doubles4 [[gnu::vector_size(32)]] = double;
using Doubles8 [[gnu::vector_size(64)]] = double;

template <typename V>
constexpr int kParts = static_cast<int>(kFewColumns * sizeof(double) / sizeof(V));
template <typename V>
constexpr int kLanes = static_cast<int>(sizeof(V) / sizeof(double));

template <typename V>
HPDM_INLINE void Load(const double* from, V* to) {
  std::memcpy(to, from, sizeof *to);
}
template <typename V>
HPDM_INLINE void Store(const V* from, double* to) {
  std::memcpy(to, from, sizeof *from);
}

// A matrix by its first entry and the step between columns (L) or rows (the others).
struct Lower {
  const double* data;
  Index stride;
  double operator()(Index i, Index j) const { return data[i + j * stride]; }
};

constexpr Index kTogether = 4;  // rows of X or columns of L that are taken at once

// x_i -= L(i, j) x_j, for kTogether columns j and all rows i below them.
template <typename V>
HPDM_INLINE void SolveDown(Lower L, Index n, double* X, Index stride) {
  for (int part = 0; part < kParts<V>; ++part) {
    double* const x = X + part * kLanes<V>;
    for (Index j = 0; j < n; j += kTogether) {
      const Index count = std::min(kTogether, n - j);
      V solved[kTogether] = {};
      for (Index c = 0; c < count; ++c) {
        Load(x + (j + c) * stride, &solved[c]);
        for (Index k = 0; k < c; ++k) solved[c] -= L(j + c, j + k) * solved[k];
        solved[c] /= L(j + c, j + c);
        Store(&solved[c], x + (j + c) * stride);
      }
      if (count < kTogether) break;
      const double* const l = L.data + j * L.stride;
      for (Index i = j + kTogether; i < n; ++i) {
        V row;
        Load(x + i * stride, &row);
        for (Index c = 0; c < kTogether; ++c) row -= l[i + c * L.stride] * solved[c];
        Store(&row, x + i * stride);
      }
    }
  }
}

// x_j = (x_j - sum of L(i, j) x_i over the rows i below) / L(j, j), for kTogether columns j at once.
template <typename V>
HPDM_INLINE void SolveUp(Lower L, Index n, double* X, Index stride) {
  for (int part = 0; part < kParts<V>; ++part) {
    double* const x = X + part * kLanes<V>;
    for (Index end = n; end > 0;) {
      const Index count = std::min(kTogether, end), j = end - count;
      V sum[kTogether] = {};
      if (count == kTogether) {
        const double* const l = L.data + j * L.stride;
        for (Index i = end; i < n; ++i) {
          V row;
          Load(x + i * stride, &row);
          for (Index c = 0; c < kTogether; ++c) sum[c] += l[i + c * L.stride] * row;
        }
      } else {
        for (Index i = end; i < n; ++i) {
          V row;
          Load(x + i * stride, &row);
          for (Index c = 0; c < count; ++c) sum[c] += L(i, j + c) * row;
        }
      }
      V solved[kTogether] = {};
      for (Index c = count - 1; c >= 0; --c) {
        Load(x + (j + c) * stride, &solved[c]);
        solved[c] -= sum[c];
        for (Index k = c + 1; k < count; ++k) solved[c] -= L(j + k, j + c) * solved[k];
        solved[c] /= L(j + c, j + c);
        Store(&solved[c], x + (j + c) * stride);
      }
      end = j;
    }
  }
}

template <int kRows, bool kAdd, typename V>
HPDM_INLINE void MultiplyRows(const double* a, Index a_stride, Index depth, const double* x,
                              Index x_stride, double* y, Index y_stride) {
  V sum[kRows] = {};
  if constexpr (kAdd) {
    for (int r = 0; r < kRows; ++r) Load(y + r * y_stride, &sum[r]);
  }
  for (Index k = 0; k < depth; ++k) {
    V row;
    Load(x + k * x_stride, &row);
    for (int r = 0; r < kRows; ++r) sum[r] += a[r * a_stride + k] * row;
  }
  for (int r = 0; r < kRows; ++r) Store(&sum[r], y + r * y_stride);
}

template <bool kAdd, typename V>
HPDM_INLINE void MultiplyAll(const double* a, Index a_stride, Index rows, Index depth,
                             const double* X, Index x_stride, double* Y, Index y_stride) {
  for (int part = 0; part < kParts<V>; ++part) {
    const double* const x = X + part * kLanes<V>;
    double* const y = Y + part * kLanes<V>;
    Index i = 0;
    for (; i + 8 <= rows; i += 8) {
      MultiplyRows<8, kAdd, V>(a + i * a_stride, a_stride, depth, x, x_stride, y + i * y_stride,
                               y_stride);
    }
    for (; i < rows; ++i) {
      MultiplyRows<1, kAdd, V>(a + i * a_stride, a_stride, depth, x, x_stride, y + i * y_stride,
                               y_stride);
    }
  }
}

constexpr Index kPanel = 8;  // columns of a panel of the factor

// Takes the panel's `count` columns, at `l`, off the columns from `first` on: A(i, j) -= sum of
// l(i, k) l(j, k), i >= j.
template <typename V>
HPDM_INLINE void TakePanel(const double* l, Index count, double* A, Index stride, Index first,
                           Index n) {
  for (Index j = first; j < n; ++j) {
    double* const column = A + j * stride;
    double of_row[kPanel] = {};
    for (Index k = 0; k < count; ++k) of_row[k] = l[j + k * stride];
    Index i = j;
    if (count == kPanel) {
      for (; i + kLanes<V> <= n; i += kLanes<V>) {
        V sum;
        Load(column + i, &sum);
        for (Index k = 0; k < kPanel; ++k) {
          V part;
          Load(l + i + k * stride, &part);
          sum -= of_row[k] * part;
        }
        Store(&sum, column + i);
      }
    }
    for (; i < n; ++i) {
      double sum = column[i];
      for (Index k = 0; k < count; ++k) sum -= of_row[k] * l[i + k * stride];
      column[i] = sum;
    }
  }
}

template <typename V>
HPDM_INLINE bool Factor(double* A, Index stride, Index done, Index n) {
  for (Index first = 0; first < done; first += kPanel) {
    TakePanel<V>(A + first * stride, std::min(kPanel, done - first), A, stride, done, n);
  }
  for (Index first = done; first < n; first += kPanel) {
    const Index count = std::min(kPanel, n - first), end = first + count;
    for (Index j = first; j < end; ++j) {
      double* const column = A + j * stride;
      for (Index k = first; k < j; ++k) {
        const double* const other = A + k * stride;
        const double factor = other[j];
        for (Index i = j; i < n; ++i) column[i] -= factor * other[i];
      }
      if (!(column[j] > 0)) return false;
      const double root = std::sqrt(column[j]);
      for (Index i = j; i < n; ++i) column[i] /= root;
    }
    TakePanel<V>(A + first * stride, count, A, stride, end, n);
  }
  return true;
}

struct Kernels {
  bool (*factor)(double* A, Index stride, Index done, Index n);
  void (*solve_down)(Lower L, Index n, double* X, Index stride);
  void (*solve_up)(Lower L, Index n, double* X, Index stride);
  using MultiplyFunction = void(const double* a, Index a_stride, Index rows, Index depth,
                                const double* X, Index x_stride, double* Y, Index y_stride);
  MultiplyFunction* multiply;
  MultiplyFunction* multiply_and_add;
};

#define HPDM_KERNELS(name, V, attribute)                                                        \
  attribute bool Factor##name(double* A, Index stride, Index done, Index n) {                   \
    return Factor<V>(A, stride, done, n);                                                       \
  }                                                                                             \
  attribute void SolveDown##name(Lower L, Index n, double* X, Index stride) {                   \
    SolveDown<V>(L, n, X, stride);                                                              \
  }                                                                                             \
  attribute void SolveUp##name(Lower L, Index n, double* X, Index stride) {                     \
    SolveUp<V>(L, n, X, stride);                                                                \
  }                                                                                             \
  attribute void Multiply##name(const double* a, Index a_stride, Index rows, Index depth,       \
                                const double* X, Index x_stride, double* Y, Index y_stride) {   \
    MultiplyAll<false, V>(a, a_stride, rows, depth, X, x_stride, Y, y_stride);                  \
  }                                                                                             \
  attribute void MultiplyAndAdd##name(const double* a, Index a_stride, Index rows, Index depth, \
                                      const double* X, Index x_stride, double* Y,               \
                                      Index y_stride) {                                         \
    MultiplyAll<true, V>(a, a_stride, rows, depth, X, x_stride, Y, y_stride);                   \
  }                                                                                             \
  constexpr Kernels k##name{Factor##name, SolveDown##name, SolveUp##name, Multiply##name,       \
                            MultiplyAndAdd##name};

HPDM_KERNELS(Narrow, Doubles2, )
#if defined(__x86_64__)
HPDM_KERNELS(Wide, Doubles4, [[gnu::target("avx2")]])
HPDM_KERNELS(Widest, Doubles8, [[gnu::target("avx512f")]])
#endif
#undef HPDM_KERNELS
#undef HPDM_INLINE

const Kernels& KernelsFor(VectorWidth width) {
#if defined(__x86_64__)
  if (width == VectorWidth::k64Bytes) return kWidest;
  if (width == VectorWidth::k32Bytes) return kWide;
#endif
  static_cast<void>(width);
  return kNarrow;
}

}  // namespace
}  // namespace few_columns

bool FactorLower(Eigen::Ref<Eigen::MatrixXd> A, Eigen::Index done, VectorWidth width) {
  HPDM_CHECK(A.rows() == A.cols() && done <= A.rows());
  return few_columns::KernelsFor(width).factor(A.data(), A.outerStride(), done, A.rows());
}

void SolveLower(const Eigen::Ref<const Eigen::MatrixXd>& L, Eigen::Ref<FewColumns> X,
                VectorWidth width) {
  HPDM_CHECK(L.rows() == X.rows() && L.cols() == X.rows());
  few_columns::KernelsFor(width).solve_down({L.data(), L.outerStride()}, X.rows(), X.data(),
                                            X.outerStride());
}

void SolveLowerTransposed(const Eigen::Ref<const Eigen::MatrixXd>& L, Eigen::Ref<FewColumns> X,
                          VectorWidth width) {
  HPDM_CHECK(L.rows() == X.rows() && L.cols() == X.rows());
  few_columns::KernelsFor(width).solve_up({L.data(), L.outerStride()}, X.rows(), X.data(),
                                          X.outerStride());
}

void Multiply(const Eigen::Ref<const RowMajorMatrix>& A, const Eigen::Ref<const FewColumns>& X,
              Eigen::Ref<FewColumns> Y, VectorWidth width) {
  HPDM_CHECK(A.cols() == X.rows() && A.rows() == Y.rows());
  few_columns::KernelsFor(width).multiply(A.data(), A.outerStride(), A.rows(), A.cols(), X.data(),
                                          X.outerStride(), Y.data(), Y.outerStride());
}

void MultiplyAndAdd(const Eigen::Ref<const RowMajorMatrix>& A,
                    const Eigen::Ref<const FewColumns>& X, Eigen::Ref<FewColumns> Y,
                    VectorWidth width) {
  HPDM_CHECK(A.cols() == X.rows() && A.rows() == Y.rows());
  few_columns::KernelsFor(width).multiply_and_add(A.data(), A.outerStride(), A.rows(), A.cols(),
                                                  X.data(), X.outerStride(), Y.data(),
                                                  Y.outerStride());
}

}  // namespace hpdm
