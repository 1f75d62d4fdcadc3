#pragma once

#include <Eigen/Core>

#include "engine/types.h"
#include "render/laparoscope_options.h"

namespace hpdm {

/// The laparoscope as a camera: where it is, which way it looks, and how a point of the world
/// becomes a pixel of its circular picture.
///
/// Frames (right-handed; X_AB is the pose of B in A, p_A = X_AB p_B):
///   W  the world.
///   C  the camera: origin at the scope's tip, x to the right and y to the top of the picture, z
///      against the viewing axis (OpenGL's camera). The viewing axis points at the target. y is
///      as close to the world's z as it can be; looking along z, to the world's y.
///   S  the shaft: the same origin and x; z along the shaft in the direction of insertion. The
///      viewing axis is tilted from it by the angle of the optics towards the picture's bottom,
///      as on a scope held with its mark up; the shaft therefore lies above the line of sight.
///
/// The picture is a pinhole's: the cone of `field_of_view` about the viewing axis is the circle,
/// centred in the picture, whose diameter is kCircleFraction of the shorter side.
///
/// Immutable, so any thread may read it.
class Laparoscope {
 public:
  static constexpr int kMinSide = 16;    ///< px.
  static constexpr int kMaxSide = 8192;  ///< px.
  static constexpr double kCircleFraction = 0.98;
  static constexpr double kNear = 0.002;         ///< m: nothing nearer is drawn.
  static constexpr double kFar = 2.0;            ///< m.
  static constexpr double kLightOffset = 0.004;  ///< m, from the lens towards y_C: the fibres'
                                                 ///< exit on the face of a 10 mm scope.

  /// Throws InputError when the tip and the target coincide, the field of view is not between 5
  /// and 150 degrees, the angle of the optics is not in [0, 90) degrees, or the picture is not
  /// between 16 and 8,192 pixels on a side.
  Laparoscope(const LaparoscopeOptions& options, int width, int height);

  int width() const { return width_; }    ///< px.
  int height() const { return height_; }  ///< px.

  const Isometry3d& X_WC() const { return X_WC_; }
  const Isometry3d& X_WS() const { return X_WS_; }
  Vector3d ViewingAxis_W() const { return -X_WC_.linear().col(2); }  ///< Unit.
  Vector3d p_light_W() const { return X_WC_ * Vector3d(0, kLightOffset, 0); }
  double target_distance() const { return target_distance_; }  ///< m, from the tip.

  double focal_length_px() const { return focal_length_px_; }
  double circle_radius_px() const { return circle_radius_px_; }

  /// Homogeneous clip coordinates (OpenGL's: -w <= x, y, z <= w) from camera or world points.
  Eigen::Matrix4d ClipFromCamera() const;
  Eigen::Matrix4d ClipFromWorld() const;

  /// Where a world point appears: x from the picture's left edge and y from its top edge (px; a
  /// pixel's centre is at half-integers), then its distance along the viewing axis (m; only a
  /// positive one can be seen).
  Vector3d Project(const Vector3d& p_W) const;

 private:
  int width_;
  int height_;
  double target_distance_;
  double circle_radius_px_;
  double focal_length_px_;
  Isometry3d X_WC_ = Isometry3d::Identity();
  Isometry3d X_WS_ = Isometry3d::Identity();
};

}  // namespace hpdm
