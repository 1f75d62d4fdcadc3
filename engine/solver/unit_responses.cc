#include "engine/solver/unit_responses.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "engine/base/check.h"

namespace hpdm {
namespace unit_responses {
namespace {

using Eigen::Index;

constexpr Index kTile = 192;       // rows of a tile of all responses, which stays in the cache
constexpr std::size_t kMost = 64;  // rows b at once

// Extensions of GCC and Clang.
using Doubles2 [[gnu::vector_size(16)]] = double;
using Doubles4 [[gnu::vector_size(32)]] = double;
using Doubles8 [[gnu::vector_size(64)]] = double;

// y += factor x, of `count` entries.
template <typename V>
[[gnu::always_inline]] inline void AddScaled(double factor, const double* x, double* y,
                                             Index count) {
  constexpr Index kLanes = sizeof(V) / sizeof(double);
  Index i = 0;
  for (; i + kLanes <= count; i += kLanes) {
    V from, to;
    std::memcpy(&from, x + i, sizeof from);
    std::memcpy(&to, y + i, sizeof to);
    to += factor * from;
    std::memcpy(y + i, &to, sizeof to);
  }
  for (; i < count; ++i) y[i] += factor * x[i];
}

// Adds to three columns.
using AddFunction = void (*)(double factor, const double* x, Index x_stride, double* y,
                             Index y_stride, Index count);

#define HPDM_ADD(name, V, attribute)                                                               \
  attribute void Add##name(double factor, const double* x, Index x_stride, double* y,              \
                           Index y_stride, Index count) {                                          \
    for (Index d = 0; d < 3; ++d) AddScaled<V>(factor, x + d * x_stride, y + d * y_stride, count); \
  }

HPDM_ADD(Narrow, Doubles2, )
#if defined(__x86_64__)
HPDM_ADD(Wide, Doubles4, [[gnu::target("avx2")]])
HPDM_ADD(Widest, Doubles8, [[gnu::target("avx512f")]])
#endif
#undef HPDM_ADD

AddFunction AddFor(VectorWidth width) {
#if defined(__x86_64__)
  if (width == VectorWidth::k64Bytes) return &AddWidest;
  if (width == VectorWidth::k32Bytes) return &AddWide;
#endif
  static_cast<void>(width);
  return &AddNarrow;
}

// Adds the columns of all control points to rows `first` on of the responses.
void AddTile(AddFunction add, const Eigen::MatrixXd& inverse, std::span<const SparseRow> rows,
             Index first, Index count, Eigen::Ref<Eigen::MatrixXd> responses) {
  const auto n = static_cast<int>(inverse.rows() / 3);
  std::array<std::size_t, kMost> next{};  // entry of each row
  while (true) {
    int point = n;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const auto points = rows[i].control_points;
      if (next[i] < points.size()) point = std::min(point, points[next[i]]);
    }
    if (point == n) return;
    const double* const columns = inverse.data() + first + 3 * point * inverse.outerStride();
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const auto points = rows[i].control_points;
      if (next[i] == points.size() || points[next[i]] != point) continue;
      double* const to =
          responses.data() + first + 3 * static_cast<Index>(i) * responses.outerStride();
      add(rows[i].weights[next[i]++], columns, inverse.outerStride(), to, responses.outerStride(),
          count);
    }
  }
}

}  // namespace
}  // namespace unit_responses

void FillUnitResponses(const Eigen::MatrixXd& inverse, std::span<const SparseRow> rows,
                       Eigen::Ref<Eigen::MatrixXd> responses, VectorWidth width) {
  using namespace unit_responses;
  HPDM_CHECK(rows.size() <= kMost && responses.rows() == inverse.rows());
  HPDM_CHECK(responses.cols() == 3 * static_cast<Index>(rows.size()));
  responses.setZero();
  for (Index first = 0; first < inverse.rows(); first += kTile) {
    AddTile(AddFor(width), inverse, rows, first, std::min(kTile, inverse.rows() - first),
            responses);
  }
}

}  // namespace hpdm
