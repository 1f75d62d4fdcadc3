#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "engine/base/check.h"
#include "render/image/image_file.h"

namespace hpdm {

/// Difference of two pictures of one size: CIELAB distances (CIE 1976; about 2.3 is just
/// noticeable) after a blur over 5 x 5 pixels. The blur hides edges that another driver samples
/// differently. Missing, moved or recoloured parts remain.
struct PictureDifference {
  double mean = 0;
  double p99 = 0;  ///< 99 % of the pixels are nearer than this.
};

/// CIELAB of an 8-bit sRGB pixel, white D65.
inline Eigen::Array3d LabOf(const std::uint8_t* srgb) {
  Eigen::Array3d linear;
  for (int c = 0; c < 3; ++c) {
    const double s = srgb[c] / 255.0;
    linear[c] = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
  }
  Eigen::Matrix3d xyz_from_rgb;  // IEC 61966-2-1
  xyz_from_rgb << 0.4124, 0.3576, 0.1805, 0.2126, 0.7152, 0.0722, 0.0193, 0.1192, 0.9505;
  const Eigen::Array3d white(0.9505, 1, 1.089);
  const Eigen::Array3d t = (xyz_from_rgb * linear.matrix()).array() / white;
  const Eigen::Array3d f =
      t.unaryExpr([](double x) { return x > 0.008856 ? std::cbrt(x) : 7.787 * x + 16.0 / 116; });
  return {116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])};
}

inline PictureDifference Compare(const Image& a, const Image& b) {
  HPDM_CHECK(a.width == b.width && a.height == b.height);
  const int width = a.width, height = a.height;
  std::vector<Eigen::Array3d> difference;
  difference.reserve(a.rgb.size() / 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) difference.push_back(LabOf(a.At(x, y)) - LabOf(b.At(x, y)));
  }
  constexpr int kReach = 2;  // px: the blur is linear, so that of the difference is theirs
  std::vector<double> distance;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      Eigen::Array3d sum = Eigen::Array3d::Zero();
      for (int dy = -kReach; dy <= kReach; ++dy) {
        for (int dx = -kReach; dx <= kReach; ++dx) {
          const int at_y = std::clamp(y + dy, 0, height - 1);
          const int at_x = std::clamp(x + dx, 0, width - 1);
          sum += difference[static_cast<std::size_t>(at_y * width + at_x)];
        }
      }
      distance.push_back(sum.matrix().norm() / ((2 * kReach + 1) * (2 * kReach + 1)));
    }
  }
  PictureDifference result;
  for (const double d : distance) result.mean += d / static_cast<double>(distance.size());
  const auto p99 = distance.begin() + static_cast<std::ptrdiff_t>(distance.size() * 99 / 100);
  std::nth_element(distance.begin(), p99, distance.end());
  result.p99 = *p99;
  return result;
}

}  // namespace hpdm
