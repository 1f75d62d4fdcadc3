#pragma once

#include <array>

#include "engine/base/types.h"

namespace hpdm {

/// A mark that a teacher puts on the picture. It stays at its place of the picture when the scope moves.
struct PictureMark {
  enum class Kind { kPoint, kBleeding };
  Kind kind = Kind::kPoint;
  double x = 0, y = 0;          ///< 0..1 of the picture, from its left and top.
  Nanoseconds since_ns = 0;     ///< Session time; a bleeding grows from then on.
  std::array<char, 64> text{};  ///< Ends with a zero.
};

/// Main thread -> render loop, latest value.
struct PictureMarks {
  static constexpr int kMost = 8;
  int count = 0;
  std::array<PictureMark, kMost> marks;
};

}  // namespace hpdm
