#include "render/camera/laparoscope.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "engine/base/error.h"

namespace hpdm {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
// Positions of 0.1 m in double give 1e-13 px after a focal length of some 400 px; rounder is ample.
constexpr double kPixelRoundOff = 1e-9;

LaparoscopeOptions Oblique() {
  LaparoscopeOptions options;
  options.p_scope_W = Vector3d(-0.04, -0.2, 0.15);
  options.p_target_W = Vector3d(0.02, 0.01, 0.03);
  options.angle = 30 * kDegree;
  options.field_of_view = 70 * kDegree;
  return options;
}

TEST(Laparoscope, TheTargetIsInTheMiddleOfThePictureAtItsDistance) {
  for (const double angle : {0.0, 30 * kDegree, 45 * kDegree}) {
    LaparoscopeOptions options = Oblique();
    options.angle = angle;
    const Laparoscope scope(options, 640, 480);
    const Vector3d pixel = scope.Project(options.p_target_W);
    EXPECT_NEAR(pixel.x(), 320, kPixelRoundOff);
    EXPECT_NEAR(pixel.y(), 240, kPixelRoundOff);
    EXPECT_NEAR(pixel.z(), (options.p_target_W - options.p_scope_W).norm(), 1e-15);
  }
}

TEST(Laparoscope, TheConeOfTheFieldOfViewIsTheCircle) {
  const LaparoscopeOptions options = Oblique();
  const Laparoscope scope(options, 640, 480);
  EXPECT_DOUBLE_EQ(scope.circle_radius_px(), 0.98 * 240);
  for (int i = 0; i < 12; ++i) {
    const double around = i * 30 * kDegree, half = options.field_of_view / 2;
    const Vector3d p_C = 0.13 * Vector3d(std::sin(half) * std::cos(around),
                                         std::sin(half) * std::sin(around), -std::cos(half));
    const Vector3d pixel = scope.Project(scope.X_WC() * p_C);
    EXPECT_NEAR(std::hypot(pixel.x() - 320, pixel.y() - 240), scope.circle_radius_px(),
                kPixelRoundOff);
  }
}

TEST(Laparoscope, ThePictureIsUprightAndNotMirrored) {
  LaparoscopeOptions options;  // from -y, looking along +y: right is +x, up is +z
  options.p_scope_W = Vector3d(0, -0.2, 0);
  const Laparoscope scope(options, 640, 480);
  EXPECT_GT(scope.Project(Vector3d(0.01, 0, 0)).x(), 320);
  EXPECT_LT(scope.Project(Vector3d(0, 0, 0.01)).y(), 240);
  EXPECT_NEAR(scope.X_WC().linear().determinant(), 1, 1e-14);
}

TEST(Laparoscope, TheViewingAxisIsTiltedFromTheShaftTowardsThePicturesBottom) {
  const LaparoscopeOptions options = Oblique();
  const Laparoscope scope(options, 640, 480);
  const Vector3d shaft_W = scope.ShaftAxis_W();
  EXPECT_NEAR(std::acos(shaft_W.dot(scope.ViewingAxis_W())), options.angle, 1e-12);
  EXPECT_NEAR(shaft_W.dot(scope.X_WC().linear().col(0)), 0, 1e-14);
  // The shaft points above what is seen: the view is tilted downwards from it.
  EXPECT_GT(shaft_W.dot(scope.X_WC().linear().col(1)), 0);
  EXPECT_TRUE((scope.p_trocar_W() + kScopeDepth * shaft_W).isApprox(options.p_scope_W, 1e-14));
}

TEST(Laparoscope, StraightOpticsLookAlongTheShaft) {
  LaparoscopeOptions options = Oblique();
  options.angle = 0;
  const Laparoscope scope(options, 640, 480);
  EXPECT_TRUE(scope.ShaftAxis_W().isApprox(scope.ViewingAxis_W(), 1e-14));
}

LaparoscopeOptions ThroughATrocar() {
  LaparoscopeOptions options = Oblique();
  options.p_trocar_W = Vector3d(-0.05, -0.25, 0.22);
  return options;
}

TEST(Laparoscope, ATrocarFixesTheShaftAndTheOpticsTurnTowardsTheTarget) {
  const LaparoscopeOptions options = ThroughATrocar();
  const Laparoscope scope(options, 640, 480);
  const Vector3d shaft_W = (options.p_scope_W - *options.p_trocar_W).normalized();
  EXPECT_TRUE(scope.ShaftAxis_W().isApprox(shaft_W, 1e-14));
  EXPECT_NEAR(std::acos(shaft_W.dot(scope.ViewingAxis_W())), options.angle, 1e-12);
  // Axis, shaft and target lie in one plane, axis and target on the same side of the shaft.
  const Vector3d to_target_W = (options.p_target_W - options.p_scope_W).normalized();
  EXPECT_NEAR(shaft_W.cross(to_target_W).normalized().dot(scope.ViewingAxis_W()), 0, 1e-14);
  EXPECT_GT(shaft_W.cross(to_target_W).dot(shaft_W.cross(scope.ViewingAxis_W())), 0);
}

TEST(Laparoscope, ATargetAheadOfTheShaftTiltsTheOpticsDown) {
  LaparoscopeOptions options = Oblique();
  options.p_trocar_W = options.p_scope_W + (options.p_scope_W - options.p_target_W);
  const Laparoscope scope(options, 640, 480);
  EXPECT_LT(scope.ViewingAxis_W().z(), scope.ShaftAxis_W().z());
  EXPECT_NEAR(std::acos(scope.ShaftAxis_W().dot(scope.ViewingAxis_W())), options.angle, 1e-12);
}

TEST(Laparoscope, AMovedScopeStillPassesItsTrocar) {
  const LaparoscopeOptions from = ThroughATrocar();
  const LaparoscopeOptions to =
      Moved(from, {.up = 0.2, .right = -0.1, .insertion = 0.03, .roll = 0.5, .zoom = 1.5});
  EXPECT_EQ(*to.p_trocar_W, *from.p_trocar_W);
  const double before = (from.p_scope_W - *from.p_trocar_W).norm();
  EXPECT_NEAR((to.p_scope_W - *to.p_trocar_W).norm(), before + 0.03, 1e-14);
  const Laparoscope scope(to, 640, 480);
  EXPECT_NEAR(std::acos(scope.ShaftAxis_W().dot(scope.ViewingAxis_W())), from.angle, 1e-12);
  EXPECT_NEAR(std::tan(to.field_of_view / 2), std::tan(from.field_of_view / 2) / 1.5, 1e-14);
}

TEST(Laparoscope, AZeroMovementKeepsThePicture) {
  for (const LaparoscopeOptions& from : {Oblique(), ThroughATrocar()}) {
    const Laparoscope before(from, 640, 480), after(Moved(from, {}), 640, 480);
    EXPECT_TRUE(after.X_WC().isApprox(before.X_WC(), 1e-13));
    EXPECT_NEAR(after.focal_length_px(), before.focal_length_px(), kPixelRoundOff);
  }
}

TEST(Laparoscope, MovesFollowThePicturesAxes) {
  const LaparoscopeOptions from = ThroughATrocar();
  const Laparoscope scope(from, 640, 480);
  const Vector3d right_W = scope.X_WC().linear().col(0), up_W = scope.X_WC().linear().col(1);
  const auto turned = [&](const ScopeMove& move) {
    return Vector3d(Laparoscope(Moved(from, move), 640, 480).ViewingAxis_W() -
                    scope.ViewingAxis_W());
  };
  EXPECT_GT(turned({.right = 0.05}).dot(right_W), 0.04);
  EXPECT_GT(turned({.up = 0.05}).dot(up_W), 0.04);
  // Rolling turns the view about the shaft, which stays.
  const Laparoscope rolled(Moved(from, {.roll = 1.0}), 640, 480);
  EXPECT_TRUE(rolled.ShaftAxis_W().isApprox(scope.ShaftAxis_W(), 1e-14));
  EXPECT_GT((rolled.ViewingAxis_W() - scope.ViewingAxis_W()).norm(), 0.3);
}

TEST(Laparoscope, MovesStayWithinTheirLimits) {
  const LaparoscopeOptions from = ThroughATrocar();
  const auto depth = [](const LaparoscopeOptions& o) {
    return (o.p_scope_W - *o.p_trocar_W).norm();
  };
  EXPECT_NEAR(depth(Moved(from, {.insertion = 1})), kMaxScopeInsertion, 1e-14);
  EXPECT_NEAR(depth(Moved(from, {.insertion = -1})), kMinScopeInsertion, 1e-14);
  EXPECT_DOUBLE_EQ(Moved(from, {.zoom = 100}).field_of_view, kMinFieldOfView);
  EXPECT_DOUBLE_EQ(Moved(from, {.zoom = 0.01}).field_of_view, kMaxFieldOfView);
}

TEST(Laparoscope, OtherOpticsKeepTheShaft) {
  const Laparoscope straight(WithOptics(Oblique(), 0), 640, 480);
  EXPECT_TRUE(
      straight.ShaftAxis_W().isApprox(Laparoscope(Oblique(), 640, 480).ShaftAxis_W(), 1e-13));
  EXPECT_TRUE(straight.ViewingAxis_W().isApprox(straight.ShaftAxis_W(), 1e-13));
}

TEST(Laparoscope, DistortionKeepsTheMiddleAndTheCirclesEdge) {
  for (const double distortion : {-0.3, -0.1, 0.2}) {
    LaparoscopeOptions options = Oblique();
    options.distortion = distortion;
    const Laparoscope scope(options, 640, 480);
    const double edge = std::tan(options.field_of_view / 2);
    EXPECT_EQ(scope.Distorted(0), 0);
    EXPECT_NEAR(scope.Distorted(edge), edge, 1e-15);
    double last = 0;
    for (int i = 1; i <= 20; ++i) {
      const double tangent = edge * i / 20, seen = scope.Distorted(tangent);
      EXPECT_GT(seen, last);  // nothing folds over
      EXPECT_EQ(seen > tangent, distortion < 0 && i < 20) << "barrel magnifies the middle";
      EXPECT_NEAR(scope.Undistorted(seen), tangent, 1e-13);
      last = seen;
    }
  }
}

TEST(Laparoscope, ClipCoordinatesAgreeWithProject) {
  const Laparoscope scope(Oblique(), 641, 480);
  const Vector3d p_W(0.05, 0.03, 0.0);
  const Eigen::Vector4d clip = scope.ClipFromWorld() * p_W.homogeneous();
  const Vector3d pixel = scope.Project(p_W);
  EXPECT_NEAR((clip.x() / clip.w() + 1) * 0.5 * 641, pixel.x(), kPixelRoundOff);
  EXPECT_NEAR((1 - clip.y() / clip.w()) * 0.5 * 480, pixel.y(), kPixelRoundOff);
  EXPECT_NEAR(clip.w(), pixel.z(), 1e-15);
}

TEST(Laparoscope, DepthRangeEndsAtNearAndFar) {
  const Laparoscope scope(Oblique(), 640, 480);
  const auto depth = [&](double distance) {
    const Eigen::Vector4d clip = scope.ClipFromCamera() * Eigen::Vector4d(0, 0, -distance, 1);
    return clip.z() / clip.w();
  };
  EXPECT_NEAR(depth(Laparoscope::kNear), -1, 1e-12);
  EXPECT_NEAR(depth(Laparoscope::kFar), 1, 1e-12);
}

TEST(Laparoscope, LookingStraightDownHasAPose) {
  LaparoscopeOptions options;
  options.p_scope_W = Vector3d(0, 0, 0.2);
  const Laparoscope scope(options, 640, 480);
  EXPECT_NEAR(scope.Project(Vector3d::Zero()).x(), 320, kPixelRoundOff);
  EXPECT_LT(scope.Project(Vector3d(0, 0.01, 0)).y(), 240);  // the world's y is up
}

TEST(Laparoscope, ImpossibleOptionsAreRefused) {
  LaparoscopeOptions at_target = Oblique();
  at_target.p_scope_W = at_target.p_target_W;
  EXPECT_THROW(Laparoscope(at_target, 640, 480), InputError);
  LaparoscopeOptions not_a_number = Oblique();
  not_a_number.p_scope_W.x() = std::nan("");
  EXPECT_THROW(Laparoscope(not_a_number, 640, 480), InputError);
  LaparoscopeOptions wide = Oblique();
  wide.field_of_view = std::numbers::pi;
  EXPECT_THROW(Laparoscope(wide, 640, 480), InputError);
  LaparoscopeOptions bent = Oblique();
  bent.angle = std::numbers::pi / 2;
  EXPECT_THROW(Laparoscope(bent, 640, 480), InputError);
  LaparoscopeOptions folded = Oblique();
  folded.distortion = -0.34;
  EXPECT_THROW(Laparoscope(folded, 640, 480), InputError);
  LaparoscopeOptions at_trocar = Oblique();
  at_trocar.p_trocar_W = at_trocar.p_scope_W;
  EXPECT_THROW(Laparoscope(at_trocar, 640, 480), InputError);
  EXPECT_THROW(Laparoscope(Oblique(), 0, 480), InputError);
}

}  // namespace
}  // namespace hpdm
