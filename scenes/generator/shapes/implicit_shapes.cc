#include "scenes/generator/shapes/implicit_shapes.h"

#include <algorithm>
#include <cmath>

#include "engine/base/check.h"

namespace hpdm {

Vector3d ProjectToLevel(const ImplicitShape& shape, const Vector3d& p, double level) {
  constexpr double kTolerance = 1e-10, kMaxStep = 5e-3;
  Vector3d q = p;
  for (int iteration = 0; iteration < 30; ++iteration) {
    const FieldSample field = shape.Sample(q);
    const double error = field.value - level;
    const double slope_squared = field.gradient.squaredNorm();
    if (std::abs(error) < kTolerance || slope_squared < 1e-6) break;
    Vector3d step = field.gradient * (error / slope_squared);
    const double length = step.norm();
    if (length > kMaxStep) step *= kMaxStep / length;
    q -= step;
  }
  return q;
}

Vector3d NearestSurfacePoint(const ImplicitShape& shape, const Vector3d& p) {
  constexpr double kTolerance = 1e-9;
  Vector3d foot = ProjectToLevel(shape, p, 0);
  for (int iteration = 0; iteration < 200; ++iteration) {
    const Vector3d gradient = shape.Sample(foot).gradient;
    const Vector3d offset = p - foot;
    const Vector3d along = offset - gradient * (gradient.dot(offset) / gradient.squaredNorm());
    if (along.norm() < kTolerance) break;
    foot = ProjectToLevel(shape, foot + 0.5 * along, 0);
  }
  return foot;
}

FieldSample SmoothUnion(const FieldSample& a, const FieldSample& b, double rounding) {
  const FieldSample& low = a.value < b.value ? a : b;
  const FieldSample& high = a.value < b.value ? b : a;
  const double h = 1 - (high.value - low.value) / rounding;
  if (h <= 0) return low;
  return {low.value - 0.25 * h * h * rounding,
          low.gradient * (1 - 0.5 * h) + high.gradient * (0.5 * h)};
}

FieldSample SmoothDifference(const FieldSample& a, const FieldSample& b, double rounding) {
  const FieldSample outside = SmoothUnion({-a.value, -a.gradient}, {b.value, b.gradient}, rounding);
  return {-outside.value, -outside.gradient};
}

Ellipsoid::Ellipsoid(const Vector3d& centre, const Vector3d& semi_axes, const Vector3d& axis,
                     const Vector3d& up)
    : centre_(centre), semi_axes_(semi_axes) {
  axes_.col(0) = axis / axis.norm();
  const Vector3d square = up - axes_.col(0) * axes_.col(0).dot(up);
  axes_.col(1) = square / square.norm();
  axes_.col(2) = axes_.col(0).cross(axes_.col(1));
}

FieldSample Ellipsoid::Sample(const Vector3d& p) const {
  // d = k0 (k0 - 1) / k1 with k0 = |q / r| and k1 = |q / r^2|. It is zero on the surface, with a
  // gradient of length one there.
  const Vector3d q(axes_.col(0).dot(p - centre_), axes_.col(1).dot(p - centre_),
                   axes_.col(2).dot(p - centre_));
  Vector3d u, v, w;  // q / r, q / r^2, q / r^4
  for (int k = 0; k < 3; ++k) {
    const double r = semi_axes_[k];
    u[k] = q[k] / r;
    v[k] = u[k] / r;
    w[k] = v[k] / (r * r);
  }
  const double k0 = u.norm(), k1 = v.norm();
  if (k1 < 1e-9) return {-semi_axes_.minCoeff(), Vector3d::Zero()};
  const Vector3d gradient_k0 = v / k0, gradient_k1 = w / k1;
  const Vector3d local =
      gradient_k0 * ((2 * k0 - 1) / k1) - gradient_k1 * (k0 * (k0 - 1) / (k1 * k1));
  return {k0 * (k0 - 1) / k1,
          axes_.col(0) * local[0] + axes_.col(1) * local[1] + axes_.col(2) * local[2]};
}

Bounds Ellipsoid::bounds() const {
  const double r = 1.1 * semi_axes_.maxCoeff();
  return {centre_ - Vector3d::Constant(r), centre_ + Vector3d::Constant(r)};
}

SweptBall::SweptBall(std::vector<Node> nodes) {
  HPDM_CHECK(nodes.size() >= 2);
  // One more node beyond each end, mirrored, makes the spline start and stop at the end nodes.
  const auto mirrored = [](const Node& end, const Node& next) {
    return Node{2 * end.centre - next.centre, 2 * end.radius - next.radius};
  };
  nodes_.push_back(mirrored(nodes[0], nodes[1]));
  nodes_.insert(nodes_.end(), nodes.begin(), nodes.end());
  nodes_.push_back(mirrored(nodes[nodes.size() - 1], nodes[nodes.size() - 2]));
  constexpr int kBallsPerSpan = 8;
  for (int i = 0; i <= span_count() * kBallsPerSpan; ++i) {
    balls_.push_back(At(static_cast<double>(i) / kBallsPerSpan));
  }
}

SweptBall::Ball SweptBall::At(double t) const {
  const int span = std::min(static_cast<int>(t), span_count() - 1);
  const double s = t - span, r = 1 - s;
  const double weight[4] = {r * r * r / 6, (4 - 6 * s * s + 3 * s * s * s) / 6,
                            (4 - 6 * r * r + 3 * r * r * r) / 6, s * s * s / 6};
  const double rate[4] = {-r * r / 2, (-4 * s + 3 * s * s) / 2, (4 * r - 3 * r * r) / 2, s * s / 2};
  Ball ball{Vector3d::Zero(), Vector3d::Zero(), 0, 0};
  for (int k = 0; k < 4; ++k) {
    const Node& node = nodes_[span + k];
    ball.centre += weight[k] * node.centre;
    ball.centre_rate += rate[k] * node.centre;
    ball.radius += weight[k] * node.radius;
    ball.radius_rate += rate[k] * node.radius;
  }
  return ball;
}

double SweptBall::NearestParameter(const Vector3d& p, double low, double high) const {
  // Derivative of the distance by t, times the length of the offset.
  const auto rate = [this, &p](double t) {
    const Ball ball = At(t);
    const Vector3d offset = p - ball.centre;
    return -offset.dot(ball.centre_rate) - ball.radius_rate * offset.norm();
  };
  double rate_low = rate(low), rate_high = rate(high);
  if (rate_low >= 0) return low;
  if (rate_high <= 0) return high;
  // False position. Halving the value of the retained end (the Illinois rule) makes it converge
  // faster than linearly from both sides.
  constexpr double kParameterTolerance = 1e-13, kRateTolerance = 1e-17;
  int stayed = 0;
  for (int iteration = 0; iteration < 60 && high - low > kParameterTolerance; ++iteration) {
    const double t = (low * rate_high - high * rate_low) / (rate_high - rate_low);
    const double value = rate(t);
    if (std::abs(value) < kRateTolerance) return t;
    if (value < 0) {
      low = t;
      rate_low = value;
      if (stayed == 1) rate_high *= 0.5;
      stayed = 1;
    } else {
      high = t;
      rate_high = value;
      if (stayed == -1) rate_low *= 0.5;
      stayed = -1;
    }
  }
  return 0.5 * (low + high);
}

FieldSample SweptBall::Sample(const Vector3d& p) const {
  const auto distance = [&p](const Ball& ball) { return (p - ball.centre).norm() - ball.radius; };
  int nearest = 0;
  double least = distance(balls_[0]);
  const int ball_count = static_cast<int>(balls_.size());
  for (int i = 1; i < ball_count; ++i) {
    const double d = distance(balls_[i]);
    if (d < least) {
      least = d;
      nearest = i;
    }
  }
  const double step = static_cast<double>(span_count()) / (ball_count - 1);
  const Ball ball = At(NearestParameter(p, std::max(nearest - 1, 0) * step,
                                        std::min(nearest + 1, ball_count - 1) * step));
  const Vector3d offset = p - ball.centre;
  const double length = offset.norm();
  // The parameter minimises the distance, so its own change does not enter the gradient.
  return {length - ball.radius, length > 0 ? Vector3d(offset / length) : Vector3d::Zero()};
}

Bounds SweptBall::bounds() const {
  Bounds box{nodes_[0].centre, nodes_[0].centre};
  for (const Node& node : nodes_) {
    const Vector3d reach = Vector3d::Constant(1.1 * node.radius);
    box.min = box.min.cwiseMin(node.centre - reach);
    box.max = box.max.cwiseMax(node.centre + reach);
  }
  return box;
}

}  // namespace hpdm
