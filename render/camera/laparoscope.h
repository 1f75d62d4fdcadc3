#pragma once

#include <Eigen/Core>

#include "engine/base/types.h"
#include "render/camera/laparoscope_options.h"

namespace hpdm {

/// The laparoscope as a camera: its pose, and the map from world points to pixels of its circular
/// picture. Immutable, so any thread may read it.
///
/// Frames (right-handed; X_AB is the pose of B in A, p_A = X_AB p_B):
///   W  the world.
///   C  the camera: origin at the scope's tip, x to the right and y to the top of the picture, z
///      against the viewing axis (OpenGL's camera). y is as close as possible to the world's z, or
///      to the world's y for a vertical view.
///
/// Optics: the shaft runs straight from the trocar to the tip. The viewing axis deviates from the
/// shaft by the angle of the optics:
///   with a trocar     towards the target. The target is in the middle of the picture only if the
///                     angle allows it. For a target on the shaft, the axis tilts downwards.
///   without a trocar  towards the picture's bottom, as on a scope held with its mark up. The
///                     target is in the middle; the shaft lies above the line of sight.
///
/// Picture: a pinhole camera. The cone of `field_of_view` about the viewing axis is a centred
/// circle, whose diameter is kCircleFraction of the shorter side. The lens's distortion moves
/// points inside the circle along its radius.
class Laparoscope {
 public:
  static constexpr int kMinSide = 16;    ///< px.
  static constexpr int kMaxSide = 8192;  ///< px.
  static constexpr double kCircleFraction = 0.98;
  static constexpr double kNear = kScopeNear;    ///< m: nothing nearer is drawn.
  static constexpr double kFar = 2.0;            ///< m: nothing farther is drawn.
  static constexpr double kLightOffset = 0.004;  ///< m, from the lens along y_C: the exit of the
                                                 ///< fibres on the face of a 10 mm scope.

  static constexpr double kMaxDistortion = 0.3;  ///< Below -1/3 the picture would fold over.

  /// Throws InputError if
  ///   - the tip coincides with the target or the trocar,
  ///   - the field of view is not between 5 and 150 degrees,
  ///   - the angle of the optics is not in [0, 90) degrees,
  ///   - the distortion exceeds kMaxDistortion, or
  ///   - a side of the picture is not between kMinSide and kMaxSide.
  Laparoscope(const LaparoscopeOptions& options, int width, int height);

  int width() const { return width_; }    ///< px.
  int height() const { return height_; }  ///< px.

  const Isometry3d& X_WC() const { return X_WC_; }
  Vector3d ViewingAxis_W() const { return -X_WC_.linear().col(2); }  ///< Unit.
  const Vector3d& ShaftAxis_W() const {
    return shaft_W_;
  }  ///< Unit, in the direction of insertion.
  const Vector3d& p_trocar_W() const { return p_trocar_W_; }
  Vector3d p_light_W() const { return X_WC_ * Vector3d(0, kLightOffset, 0); }
  double target_distance() const { return target_distance_; }  ///< m, from the tip.

  double focal_length_px() const { return focal_length_px_; }
  double circle_radius_px() const { return circle_radius_px_; }

  /// Matrices from camera or world points to OpenGL's clip coordinates (-w <= x, y, z <= w).
  Eigen::Matrix4d ClipFromCamera() const;
  Eigen::Matrix4d ClipFromWorld() const;

  /// Maps the tangent of a ray's angle off the viewing axis to the tangent of the pinhole ray that
  /// reaches the same pixel. Undistorted() is the inverse, for tangents inside the circle.
  double Distorted(double tangent) const;
  double Undistorted(double tangent) const;
  double distortion() const { return distortion_; }  ///< LaparoscopeOptions::distortion.

  /// Upper bound of pixels per metre for short lines in a box of the world (its lowest and highest
  /// corner, m), inside the circle. Infinite for a box that reaches nearer than kNear.
  double MostPixelsPerMetre(const Vector3d& low_W, const Vector3d& high_W) const;

  /// False only if no part of a box of the world (its lowest and highest corner, m) is in the
  /// picture.
  bool MaySee(const Vector3d& low_W, const Vector3d& high_W) const;

  /// Projects a world point. Returns x from the picture's left edge, y from its top edge (px; pixel
  /// centres are at half-integers), and the distance along the viewing axis (m; positive in front
  /// of the lens).
  Vector3d Project(const Vector3d& p_W) const;

 private:
  int width_;
  int height_;
  double target_distance_;
  double circle_radius_px_;
  double focal_length_px_;
  Isometry3d X_WC_ = Isometry3d::Identity();
  double distortion_;
  Vector3d shaft_W_;
  Vector3d p_trocar_W_;
};

/// A movement of the scope about its trocar, in the axes of its picture.
struct ScopeMove {
  double up = 0;         ///< rad, turns the view to the picture's top.
  double right = 0;      ///< rad, turns the view to the picture's right.
  double insertion = 0;  ///< m, along the shaft, inwards.
  double roll = 0;       ///< rad, of the optics about the shaft, clockwise as seen from behind.
  double zoom = 1;       ///< Factor on the focal length.
};

/// Limits of a moved scope: distance of its tip from the trocar, m, and field of view, rad.
inline constexpr double kMinScopeInsertion = 0.02, kMaxScopeInsertion = 0.30;
inline constexpr double kMinFieldOfView = 0.35, kMaxFieldOfView = 2.1;

/// Returns the scope after a movement about its trocar, within the limits above. The options must
/// be valid for a Laparoscope; so is the result, which names its trocar.
LaparoscopeOptions Moved(const LaparoscopeOptions& options, const ScopeMove& move);

/// Returns the scope with the same shaft, but with optics at another angle (rad).
LaparoscopeOptions WithOptics(const LaparoscopeOptions& options, double angle);

}  // namespace hpdm
