#include "render/laparoscope.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "engine/error.h"

namespace hpdm {
namespace {

void Require(bool condition, const std::string& message) {
  if (!condition) throw InputError("laparoscope: " + message);
}

/// Rotation of the camera that looks along the unit vector `axis_W`.
Matrix3d LookAlong(const Vector3d& axis_W) {
  const Vector3d z_W = -axis_W;
  // Within about 2 degrees of the vertical the world's z gives no steady "up".
  const bool vertical = std::abs(axis_W.z()) > 0.9994;
  const Vector3d up_W = vertical ? Vector3d::UnitY() : Vector3d::UnitZ();
  Matrix3d R_WC;
  R_WC.col(0) = up_W.cross(z_W).normalized();
  R_WC.col(1) = z_W.cross(R_WC.col(0));
  R_WC.col(2) = z_W;
  return R_WC;
}

}  // namespace

Laparoscope::Laparoscope(const LaparoscopeOptions& options, int width, int height)
    : width_(width), height_(height) {
  constexpr double kDegree = std::numbers::pi / 180;
  const auto in_range = [](int side) { return side >= kMinSide && side <= kMaxSide; };
  Require(in_range(width) && in_range(height),
          "a picture of " + std::to_string(width) + "x" + std::to_string(height) +
              " pixels cannot be drawn; choose 16 to 8192 on a side");
  Require(options.field_of_view >= 5 * kDegree && options.field_of_view <= 150 * kDegree,
          "a field of view of " + std::to_string(options.field_of_view / kDegree) +
              " degrees cannot be drawn; choose 5 to 150");
  Require(options.angle >= 0 && options.angle < 90 * kDegree,
          "an angle of the optics of " + std::to_string(options.angle / kDegree) +
              " degrees is not possible; choose 0, 30 or 45");
  const Vector3d to_target_W = options.p_target_W - options.p_scope_W;
  target_distance_ = to_target_W.norm();
  Require(target_distance_ > kNear && std::isfinite(target_distance_),
          "its position and its target coincide; move one of them");

  circle_radius_px_ = 0.5 * kCircleFraction * std::min(width, height);
  focal_length_px_ = circle_radius_px_ / std::tan(options.field_of_view / 2);

  X_WC_.linear() = LookAlong(to_target_W / target_distance_);
  X_WC_.translation() = options.p_scope_W;
  // Half a turn about x points z forwards; the optics' angle goes on turning it to the top.
  X_WS_ = X_WC_ * Eigen::AngleAxisd(std::numbers::pi + options.angle, Vector3d::UnitX());
}

Eigen::Matrix4d Laparoscope::ClipFromCamera() const {
  Eigen::Matrix4d P = Eigen::Matrix4d::Zero();
  P(0, 0) = 2 * focal_length_px_ / width_;
  P(1, 1) = 2 * focal_length_px_ / height_;
  P(2, 2) = -(kFar + kNear) / (kFar - kNear);
  P(2, 3) = -2 * kFar * kNear / (kFar - kNear);
  P(3, 2) = -1;
  return P;
}

Eigen::Matrix4d Laparoscope::ClipFromWorld() const {
  return ClipFromCamera() * X_WC_.inverse().matrix();
}

Vector3d Laparoscope::Project(const Vector3d& p_W) const {
  const Vector3d p_C = X_WC_.inverse() * p_W;
  const double depth = -p_C.z();
  return {0.5 * width_ + focal_length_px_ * p_C.x() / depth,
          0.5 * height_ - focal_length_px_ * p_C.y() / depth, depth};
}

}  // namespace hpdm
