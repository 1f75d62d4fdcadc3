#include "render/camera/laparoscope.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "engine/base/angle.h"
#include "engine/base/error.h"

namespace hpdm {
namespace {

void Require(bool condition, const std::string& message) {
  if (!condition) throw InputError("laparoscope: " + message);
}

/// Returns the rotation R_WC of a camera that looks along the unit vector `axis_W`.
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

/// Returns the unit axis at `angle` (rad) from the unit `shaft_W`, tilted towards a direction, or
/// downwards in the world if the direction lies along the shaft.
Vector3d TiltedTowards(const Vector3d& shaft_W, const Vector3d& direction_W, double angle) {
  const Vector3d candidates[] = {direction_W.normalized(), -Vector3d::UnitZ(), -Vector3d::UnitY()};
  for (const Vector3d& candidate : candidates) {
    const Vector3d aside_W = candidate - candidate.dot(shaft_W) * shaft_W;
    // A millionth of a radian is far below a pixel and far above rounding.
    if (aside_W.norm() < 1e-6) continue;
    return std::cos(angle) * shaft_W + std::sin(angle) * aside_W.normalized();
  }
  return shaft_W;
}

/// Returns the scope's pose; the picture's size does not matter for it.
Laparoscope Placed(const LaparoscopeOptions& options) { return Laparoscope(options, 64, 64); }

}  // namespace

Laparoscope::Laparoscope(const LaparoscopeOptions& options, int width, int height)
    : width_(width),
      height_(height),
      circle_radius_px_(0.5 * kCircleFraction * std::min(width, height)),
      focal_length_px_(circle_radius_px_ / std::tan(options.field_of_view / 2)),
      distortion_(options.distortion) {
  const auto in_range = [](int side) { return side >= kMinSide && side <= kMaxSide; };
  Require(in_range(width) && in_range(height),
          "a picture of " + std::to_string(width) + "x" + std::to_string(height) +
              " pixels cannot be drawn; give 16 to 8192 on a side");
  Require(options.field_of_view >= 5 * kDegree && options.field_of_view <= 150 * kDegree,
          "a field of view of " + std::to_string(options.field_of_view / kDegree) +
              " degrees cannot be drawn; give 5 to 150");
  Require(options.angle >= 0 && options.angle < 90 * kDegree,
          "an angle of the optics of " + std::to_string(options.angle / kDegree) +
              " degrees is not possible; give 0, 30 or 45");
  Require(std::abs(distortion_) <= kMaxDistortion,
          "a distortion of " + std::to_string(distortion_) + " cannot be drawn; give -0.3 to 0.3");
  const Vector3d to_target_W = options.p_target_W - options.p_scope_W;
  target_distance_ = to_target_W.norm();
  Require(target_distance_ > kNear && std::isfinite(target_distance_),
          "its position and its target coincide; move one of them");

  X_WC_.translation() = options.p_scope_W;
  if (options.p_trocar_W) {
    p_trocar_W_ = *options.p_trocar_W;
    const Vector3d to_tip_W = options.p_scope_W - p_trocar_W_;
    Require(to_tip_W.norm() > kNear && to_tip_W.allFinite(),
            "its position and its trocar coincide; move one of them");
    shaft_W_ = to_tip_W.normalized();
    X_WC_.linear() = LookAlong(TiltedTowards(shaft_W_, to_target_W, options.angle));
  } else {
    X_WC_.linear() = LookAlong(to_target_W / target_distance_);
    shaft_W_ = X_WC_.linear() * Vector3d(0, std::sin(options.angle), -std::cos(options.angle));
    p_trocar_W_ = options.p_scope_W - kScopeDepth * shaft_W_;
  }
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

double Laparoscope::Distorted(double tangent) const {
  const double edge = circle_radius_px_ / focal_length_px_, r = tangent / edge;
  return tangent * (1 + distortion_ * r * r) / (1 + distortion_);
}

double Laparoscope::Undistorted(double tangent) const {
  const double edge = circle_radius_px_ / focal_length_px_,
               target = (1 + distortion_) * tangent / edge;
  // Newton's method on r + distortion r^3 = target, which is increasing inside the circle.
  double r = tangent / edge;
  for (int i = 0; i < 20; ++i) {
    const double step = (r * (1 + distortion_ * r * r) - target) / (1 + 3 * distortion_ * r * r);
    r -= step;
    if (std::abs(step) < 1e-15) break;
  }
  return r * edge;
}

double Laparoscope::MostPixelsPerMetre(const Vector3d& low_W, const Vector3d& high_W) const {
  const Vector3d axis_W = ViewingAxis_W();
  const Vector3d middle_W = (low_W + high_W) / 2, half_W = (high_W - low_W) / 2;
  const double depth = axis_W.dot(middle_W - X_WC_.translation()) - axis_W.cwiseAbs().dot(half_W);
  if (!(depth > kNear)) return std::numeric_limits<double>::infinity();
  // At the tangent t of the angle off the axis, the longest picture is of a line along (1, -t)
  // across and along the axis. It is sqrt(1 + t^2) times as long as that of a line across. The lens
  // stretches it by at most the largest slope of Distorted(), at the edge or in the middle.
  const double edge = circle_radius_px_ / focal_length_px_;
  const double lens = std::max(1.0, 1 + 3 * distortion_) / (1 + distortion_);
  return focal_length_px_ / depth * std::sqrt(1 + edge * edge) * lens;
}

bool Laparoscope::MaySee(const Vector3d& low_W, const Vector3d& high_W) const {
  const Vector3d middle_W = (low_W + high_W) / 2 - X_WC_.translation();
  const Vector3d half_W = (high_W - low_W) / 2;
  const double x = 0.5 * width_ / focal_length_px_, y = 0.5 * height_ / focal_length_px_;
  // The picture's four sides as planes through the lens, normals inwards.
  for (const Vector3d& side_C : {Vector3d(1, 0, -x), Vector3d(-1, 0, -x), Vector3d(0, 1, -y),
                                 Vector3d(0, -1, -y), Vector3d(0, 0, -1)}) {
    const Vector3d side_W = X_WC_.linear() * side_C;
    if (side_W.dot(middle_W) + side_W.cwiseAbs().dot(half_W) < 0) return false;
  }
  return true;
}

Vector3d Laparoscope::Project(const Vector3d& p_W) const {
  const Vector3d p_C = X_WC_.inverse() * p_W;
  const double depth = -p_C.z(), tangent = p_C.head<2>().norm() / depth;
  const double lens = distortion_ == 0 || tangent == 0 ? 1 : Distorted(tangent) / tangent;
  return {0.5 * width_ + focal_length_px_ * lens * p_C.x() / depth,
          0.5 * height_ - focal_length_px_ * lens * p_C.y() / depth, depth};
}

LaparoscopeOptions Moved(const LaparoscopeOptions& options, const ScopeMove& move) {
  const Laparoscope scope = Placed(options);
  const Vector3d& p_trocar_W = scope.p_trocar_W();
  const Matrix3d R_WC = scope.X_WC().linear();
  const Matrix3d turn = (Eigen::AngleAxisd(-move.right, R_WC.col(1).normalized()) *
                         Eigen::AngleAxisd(move.up, R_WC.col(0).normalized()))
                            .toRotationMatrix();
  const double depth = (options.p_scope_W - p_trocar_W).norm();
  const double new_depth = std::clamp(depth + move.insertion, std::min(depth, kMinScopeInsertion),
                                      std::max(depth, kMaxScopeInsertion));
  const Vector3d shaft_W = turn * scope.ShaftAxis_W();
  const Matrix3d turn_optics = Eigen::AngleAxisd(move.roll, shaft_W.normalized()) * turn;

  LaparoscopeOptions moved = options;
  moved.p_trocar_W = p_trocar_W;
  moved.p_scope_W = p_trocar_W + new_depth * shaft_W;
  moved.p_target_W =
      moved.p_scope_W + turn_optics * (scope.target_distance() * scope.ViewingAxis_W());
  const double narrowest = std::min(options.field_of_view, kMinFieldOfView);
  const double widest = std::max(options.field_of_view, kMaxFieldOfView);
  moved.field_of_view =
      std::clamp(2 * std::atan(std::tan(options.field_of_view / 2) / move.zoom), narrowest, widest);
  return moved;
}

LaparoscopeOptions WithOptics(const LaparoscopeOptions& options, double angle) {
  LaparoscopeOptions changed = options;
  changed.p_trocar_W = Placed(options).p_trocar_W();
  changed.angle = angle;
  return changed;
}

}  // namespace hpdm
