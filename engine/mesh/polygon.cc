#include "engine/mesh/polygon.h"

#include <numeric>

#include "engine/base/check.h"

namespace hpdm {
namespace {

using Eigen::Vector2d;

double Cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// The corners in the plane of the polygon, counter-clockwise about its Newell normal.
std::vector<Vector2d> Flatten(const Points& corners) {
  const Eigen::Index n = corners.rows();
  const Vector3d origin = corners.colwise().mean();
  Vector3d normal = Vector3d::Zero();
  for (Eigen::Index i = 0; i < n; ++i) {
    const Vector3d a = corners.row(i).transpose() - origin;
    const Vector3d b = corners.row((i + 1) % n).transpose() - origin;
    normal += a.cross(b);
  }
  const Vector3d z = normal.norm() > 0 ? Vector3d(normal.normalized()) : Vector3d::UnitZ();
  const Vector3d x = z.unitOrthogonal();
  const Vector3d y = z.cross(x);
  std::vector<Vector2d> flat(static_cast<std::size_t>(n));
  for (Eigen::Index i = 0; i < n; ++i) {
    const Vector3d p = corners.row(i).transpose() - origin;
    flat[static_cast<std::size_t>(i)] = Vector2d(x.dot(p), y.dot(p));
  }
  return flat;
}

class EarClipper {
 public:
  explicit EarClipper(const Points& corners)
      : p_(Flatten(corners)),
        ring_(p_.size()),
        tests_left_(8 * static_cast<long>(p_.size() * p_.size())) {
    std::iota(ring_.begin(), ring_.end(), 0);
  }

  std::vector<std::array<int, 3>> Clip() {
    std::vector<std::array<int, 3>> triangles;
    std::size_t at = 0;
    while (ring_.size() > 3) {
      // Starting at the last ear instead of the first corner avoids fans of slivers.
      std::size_t tried = 0;
      while (tried < ring_.size() && !IsEar(at % ring_.size())) ++at, ++tried;
      at %= ring_.size();  // without an ear the polygon is not simple, and any corner will do
      triangles.push_back(Corner(at));
      ring_.erase(ring_.begin() + static_cast<std::ptrdiff_t>(at));
    }
    triangles.push_back({ring_[0], ring_[1], ring_[2]});
    return triangles;
  }

 private:
  const Vector2d& Point(int corner) const { return p_[static_cast<std::size_t>(corner)]; }

  /// The triangle that clipping ring_[at] cuts off.
  std::array<int, 3> Corner(std::size_t at) const {
    const std::size_t n = ring_.size();
    return {ring_[(at + n - 1) % n], ring_[at], ring_[(at + 1) % n]};
  }

  bool IsEar(std::size_t at) {
    const auto [i, j, k] = Corner(at);
    const Vector2d &a = Point(i), &b = Point(j), &c = Point(k);
    if (Cross(b - a, c - b) <= 0) return false;
    for (const int r : ring_) {
      if (--tests_left_ < 0) return true;
      const Vector2d& q = Point(r);
      if (q == a || q == b || q == c) continue;
      if (Cross(b - a, q - a) >= 0 && Cross(c - b, q - b) >= 0 && Cross(a - c, q - c) >= 0) {
        return false;
      }
    }
    return true;
  }

  std::vector<Vector2d> p_;
  std::vector<int> ring_;  // corners not clipped yet
  long tests_left_;
};

}  // namespace

std::vector<std::array<int, 3>> TriangulatePolygon(const Points& corners) {
  HPDM_CHECK(corners.rows() >= 3);
  return EarClipper(corners).Clip();
}

}  // namespace hpdm
