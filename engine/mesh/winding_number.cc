#include "engine/mesh/winding_number.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace hpdm {
namespace {

constexpr int kLeafTriangles = 8;
constexpr double kFourPi = 4 * std::numbers::pi;

/// A vector in the plane, whose direction is an angle.
struct Direction {
  double cosine, sine;  ///< Times its length.

  double Angle() const { return std::atan2(sine, cosine); }
};

/// Returns half the solid angle of a triangle seen from the origin; positive if its front faces
/// away (van Oosterom, Strackee 1983).
Direction HalfSolidAngle(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  return {la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb, a.dot(b.cross(c))};
}

/// Sums angles in (-pi, pi) as a product of directions, with one arc tangent at the end.
class AngleSum {
 public:
  void Add(const Direction& added) {
    const Direction sum = {sum_.cosine * added.cosine - sum_.sine * added.sine,
                           sum_.sine * added.cosine + sum_.cosine * added.sine};
    // On the line of 0 and pi rounding decides the side.
    if (added.sine == 0 || sum.sine == 0) {
      rest_ += added.Angle();
      return;
    }
    if (sum_.sine > 0 && added.sine > 0 && sum.sine < 0) ++turns_;
    if (sum_.sine < 0 && added.sine < 0 && sum.sine > 0) --turns_;
    sum_ = sum;
  }
  /// Keeps the product's length from leaving the range of numbers. Call after a few angles.
  void Rescale() {
    const double length = std::max(std::abs(sum_.cosine), std::abs(sum_.sine));
    sum_ = {sum_.cosine / length, sum_.sine / length};
  }
  double Sum() const { return rest_ + sum_.Angle() + 2 * std::numbers::pi * turns_; }

 private:
  Direction sum_ = {1, 0};
  int turns_ = 0;
  double rest_ = 0;
};

}  // namespace

WindingNumber::WindingNumber(const Points& vertices, const Triangles& triangles, double opening)
    : opening_(opening) {
  const auto count = static_cast<std::size_t>(triangles.rows());
  std::vector<Corners> corners(count);
  for (std::size_t t = 0; t < count; ++t) {
    for (std::size_t c = 0; c < 3; ++c) {
      const auto row = static_cast<Eigen::Index>(t);
      corners[t][c] = vertices.row(triangles(row, static_cast<Eigen::Index>(c)));
    }
  }
  std::vector<int> order(count);
  std::iota(order.begin(), order.end(), 0);
  triangles_.reserve(count);
  if (count > 0) Build(&order, corners, 0, static_cast<int>(count));
}

void WindingNumber::Build(std::vector<int>* order, const std::vector<Corners>& corners, int first,
                          int last) {
  const std::size_t self = nodes_.size();
  nodes_.emplace_back();
  nodes_[self].first = first;
  nodes_[self].last = last;
  nodes_[self].far_child = 0;
  if (last - first <= kLeafTriangles) {
    for (int i = first; i < last; ++i) {
      triangles_.push_back(
          corners[static_cast<std::size_t>((*order)[static_cast<std::size_t>(i)])]);
    }
  } else {
    const auto centre = [&](int t) -> Vector3d {
      const Corners& c = corners[static_cast<std::size_t>(t)];
      return c[0] + c[1] + c[2];
    };
    Eigen::AlignedBox3d box;
    for (int i = first; i < last; ++i) {
      box.extend(centre((*order)[static_cast<std::size_t>(i)]));
    }
    Eigen::Index axis = 0;
    box.sizes().maxCoeff(&axis);
    const int middle = (first + last) / 2;
    std::nth_element(order->begin() + first, order->begin() + middle, order->begin() + last,
                     [&](int s, int t) {
                       const double x = centre(s)[axis], y = centre(t)[axis];
                       return x < y || (x == y && s < t);  // ties by number: deterministic
                     });
    Build(order, corners, first, middle);
    nodes_[self].far_child = static_cast<int>(nodes_.size());
    Build(order, corners, middle, last);
  }
  SetMoments(&nodes_[self], opening_);
}

void WindingNumber::SetMoments(Node* node, double opening) const {
  const auto begin = triangles_.begin() + node->first, end = triangles_.begin() + node->last;
  double area = 0;
  Vector3d centre = Vector3d::Zero(), mean = Vector3d::Zero();
  for (auto t = begin; t != end; ++t) {
    const auto& [a, b, c] = *t;
    const double twice_area = (b - a).cross(c - a).norm();
    area += twice_area;
    centre += twice_area * (a + b + c) / 3;
    mean += (a + b + c) / 3;
  }
  // Triangles without any area have no area-weighted mean.
  node->centre = area > 0 ? Vector3d(centre / area)
                          : Vector3d(mean / static_cast<double>(node->last - node->first));

  double radius2 = 0;
  node->normal = node->linear = Vector3d::Zero();
  node->divergence = 0;
  node->q2 = {};
  node->q3 = {};
  for (auto t = begin; t != end; ++t) {
    const Vector3d a = (*t)[0] - node->centre, b = (*t)[1] - node->centre,
                   c = (*t)[2] - node->centre;
    radius2 = std::max({radius2, a.squaredNorm(), b.squaredNorm(), c.squaredNorm()});
    const Vector3d n = (b - a).cross(c - a) / 2;  // times the area
    const Vector3d m = (a + b + c) / 3;
    // Mean of x x^T over the triangle.
    const Matrix3d s =
        (a * a.transpose() + b * b.transpose() + c * c.transpose() + 9 * m * m.transpose()) / 12;
    node->normal += n;
    node->divergence += n.dot(m);
    node->linear += 2 * s * n + s.trace() * n;
    node->q2[0] += n.x() * m.x();
    node->q2[1] += n.y() * m.y();
    node->q2[2] += n.z() * m.z();
    node->q2[3] += n.x() * m.y() + n.y() * m.x();
    node->q2[4] += n.x() * m.z() + n.z() * m.x();
    node->q2[5] += n.y() * m.z() + n.z() * m.y();
    node->q3[0] += n.x() * s(0, 0);                                            // xxx
    node->q3[1] += n.y() * s(1, 1);                                            // yyy
    node->q3[2] += n.z() * s(2, 2);                                            // zzz
    node->q3[3] += n.y() * s(0, 0) + 2 * n.x() * s(0, 1);                      // xxy
    node->q3[4] += n.z() * s(0, 0) + 2 * n.x() * s(0, 2);                      // xxz
    node->q3[5] += n.x() * s(1, 1) + 2 * n.y() * s(0, 1);                      // xyy
    node->q3[6] += n.z() * s(1, 1) + 2 * n.y() * s(1, 2);                      // yyz
    node->q3[7] += n.x() * s(2, 2) + 2 * n.z() * s(0, 2);                      // xzz
    node->q3[8] += n.y() * s(2, 2) + 2 * n.z() * s(1, 2);                      // yzz
    node->q3[9] += 2 * (n.x() * s(1, 2) + n.y() * s(0, 2) + n.z() * s(0, 1));  // xyz
  }
  node->open_distance2 = opening * opening * radius2;
}

/// Returns int n . g(r + x) with g(r) = r / |r|^3, expanded in x to the second order. The vector r
/// points from the query point to the cluster's centre.
double WindingNumber::Far(const Node& node, const Vector3d& r) {
  const double x = r.x(), y = r.y(), z = r.z();
  const double i2 = 1 / r.squaredNorm(), i3 = i2 * std::sqrt(i2), i5 = i3 * i2, i7 = i5 * i2;
  const auto& q = node.q2;
  const double quadratic =
      x * (q[0] * x + q[3] * y + q[4] * z) + y * (q[1] * y + q[5] * z) + q[2] * z * z;
  const auto& c = node.q3;
  const double cubic = x * x * (c[0] * x + c[3] * y + c[4] * z) +
                       y * y * (c[5] * x + c[1] * y + c[6] * z) +
                       z * z * (c[7] * x + c[8] * y + c[2] * z) + c[9] * x * y * z;
  return (node.normal.dot(r) + node.divergence) * i3 -
         (3 * quadratic + 1.5 * node.linear.dot(r)) * i5 + 7.5 * cubic * i7;
}

double WindingNumber::At(const Vector3d& p) const {
  // The median split bounds the depth by log2 of the number of triangles.
  std::array<int, 64> stack;
  int size = 0;
  if (!nodes_.empty()) stack[size++] = 0;
  double far = 0;
  AngleSum near;
  while (size > 0) {
    const int index = stack[static_cast<std::size_t>(--size)];
    const Node& node = nodes_[static_cast<std::size_t>(index)];
    const Vector3d r = node.centre - p;
    if (r.squaredNorm() > node.open_distance2) {
      far += Far(node, r);
    } else if (node.far_child > 0) {
      stack[static_cast<std::size_t>(size++)] = node.far_child;
      stack[static_cast<std::size_t>(size++)] = index + 1;
    } else {
      for (int t = node.first; t < node.last; ++t) {
        const auto& [a, b, c] = triangles_[static_cast<std::size_t>(t)];
        near.Add(HalfSolidAngle(a - p, b - p, c - p));
      }
      near.Rescale();
    }
  }
  return (far + 2 * near.Sum()) / kFourPi;
}

double ExactWindingNumber(const SurfaceMesh& mesh, const Vector3d& p) {
  double sum = 0;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const Vector3d a = mesh.vertices.row(mesh.triangles(t, 0)).transpose() - p;
    const Vector3d b = mesh.vertices.row(mesh.triangles(t, 1)).transpose() - p;
    const Vector3d c = mesh.vertices.row(mesh.triangles(t, 2)).transpose() - p;
    sum += HalfSolidAngle(a, b, c).Angle();
  }
  return 2 * sum / kFourPi;
}

}  // namespace hpdm
