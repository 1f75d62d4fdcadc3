#pragma once

#include <Eigen/Core>

#include "engine/base/types.h"
#include "render/camera/laparoscope_options.h"

namespace hpdm {

/// The laparoscope as a camera: where it is, which way it looks, and how a point of the world
/// becomes a pixel of its circular picture.
///
/// Frames (right-handed; X_AB is the pose of B in A, p_A = X_AB p_B):
///   W  the world.
///   C  the camera: origin at the scope's tip, x to the right and y to the top of the picture, z
///      against the viewing axis (OpenGL's camera). The viewing axis points at the target. y is
///      as close to the world's z as it can be; looking along z, to the world's y.
///
/// The shaft goes straight from the trocar to the tip; the viewing axis leaves it by the angle of
/// the optics. Where the options name a trocar it does so towards the target, which lies in the
/// middle of the picture only if that is possible (straight below the shaft if it lies on it).
/// Where they name none the target is in the middle and the axis is tilted from the shaft towards
/// the picture's bottom, as on a scope held with its mark up; the shaft lies above the line of
/// sight.
///
/// The picture is a pinhole's: the cone of `field_of_view` about the viewing axis is the circle,
/// centred in the picture, whose diameter is kCircleFraction of the shorter side. A lens that
/// distorts moves what is inside the circle along its radius.
///
/// Immutable, so any thread may read it.
class Laparoscope {
 public:
  static constexpr int kMinSide = 16;    ///< px.
  static constexpr int kMaxSide = 8192;  ///< px.
  static constexpr double kCircleFraction = 0.98;
  static constexpr double kNear = kScopeNear;    ///< m: nothing nearer is drawn.
  static constexpr double kFar = 2.0;            ///< m.
  static constexpr double kLightOffset = 0.004;  ///< m, from the lens towards y_C: the fibres'
                                                 ///< exit on the face of a 10 mm scope.

  static constexpr double kMaxDistortion = 0.3;  ///< Below -1/3 the picture would fold over.

  /// Throws InputError when the tip coincides with the target or the trocar, the field of view is
  /// not between 5 and 150 degrees, the angle of the optics is not in [0, 90) degrees, the
  /// distortion exceeds kMaxDistortion, or the picture is not between 16 and 8,192 pixels on a
  /// side.
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

  /// Homogeneous clip coordinates (OpenGL's: -w <= x, y, z <= w) from camera or world points.
  Eigen::Matrix4d ClipFromCamera() const;
  Eigen::Matrix4d ClipFromWorld() const;

  /// Where the lens puts a ray whose angle off the viewing axis has this tangent: the tangent at
  /// which a pinhole's ray would end at the same pixel. Undistorted() is its inverse, for tangents
  /// inside the circle.
  double Distorted(double tangent) const;
  double Undistorted(double tangent) const;
  double distortion() const { return distortion_; }  ///< LaparoscopeOptions::distortion.

  /// Pixels a metre, at most, of a short line in any direction anywhere in a box of the world (its
  /// lowest and highest corner, m), where it is inside the circle; infinite for a box that reaches
  /// nearer than kNear.
  double MostPixelsPerMetre(const Vector3d& low_W, const Vector3d& high_W) const;

  /// False only where nothing of a box of the world (its lowest and highest corner, m) is in the
  /// picture.
  bool MaySee(const Vector3d& low_W, const Vector3d& high_W) const;

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
  double distortion_;
  Vector3d shaft_W_;
  Vector3d p_trocar_W_;
};

/// A movement of the scope about its trocar, in axes of its picture.
struct ScopeMove {
  double up = 0;         ///< rad, the view turns to the picture's top.
  double right = 0;      ///< rad, and to its right.
  double insertion = 0;  ///< m, along the shaft, inwards.
  double roll = 0;       ///< rad, of the optics about the shaft, clockwise as seen from behind.
  double zoom = 1;       ///< Factor on the focal length.
};

/// Limits of a moved scope: of its tip from the trocar, m, and of its field of view, rad.
inline constexpr double kMinScopeInsertion = 0.02, kMaxScopeInsertion = 0.30;
inline constexpr double kMinFieldOfView = 0.35, kMaxFieldOfView = 2.1;

/// The scope after a movement that the trocar permits, within the limits above. The options must
/// make a Laparoscope; the result does and names its trocar.
LaparoscopeOptions Moved(const LaparoscopeOptions& options, const ScopeMove& move);

/// The same scope, its shaft where it is, with optics of another angle (rad).
LaparoscopeOptions WithOptics(const LaparoscopeOptions& options, double angle);

}  // namespace hpdm
