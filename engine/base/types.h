#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>

namespace hpdm {

/// Rows are points or vectors: V x 3, metres unless a docstring says otherwise.
using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// Rows are triangles, counter-clockwise seen from outside: F x 3 vertex indices.
using Triangles = Eigen::Matrix<int, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// Rows are texture coordinates (u to the right, v up), one for each triangle corner: 3F x 2.
using TextureCoordinates = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>;

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Nanoseconds since the session began. Times that are compared or logged are integers, so they are
/// exact in both clocks. All other quantities are SI in double.
using Nanoseconds = std::int64_t;

inline constexpr Nanoseconds kNanosecondsPerSecond = 1'000'000'000;

inline double ToSeconds(Nanoseconds t) { return static_cast<double>(t) * 1e-9; }

/// Converts an index of Eigen to one of the standard library.
inline std::size_t ToSize(Eigen::Index i) { return static_cast<std::size_t>(i); }

}  // namespace hpdm
