#include "render/laparoscope.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "engine/error.h"

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
  const Vector3d shaft_W = scope.X_WS().linear().col(2);
  EXPECT_NEAR(std::acos(shaft_W.dot(scope.ViewingAxis_W())), options.angle, 1e-12);
  EXPECT_NEAR(shaft_W.dot(scope.X_WC().linear().col(0)), 0, 1e-14);
  // The shaft points above what is seen: the view is tilted downwards from it.
  EXPECT_GT(shaft_W.dot(scope.X_WC().linear().col(1)), 0);
  EXPECT_TRUE(scope.X_WS().translation().isApprox(options.p_scope_W, 1e-15));
}

TEST(Laparoscope, StraightOpticsLookAlongTheShaft) {
  LaparoscopeOptions options = Oblique();
  options.angle = 0;
  const Laparoscope scope(options, 640, 480);
  EXPECT_TRUE(scope.X_WS().linear().col(2).isApprox(scope.ViewingAxis_W(), 1e-14));
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

TEST(Laparoscope, OptionsThatCannotBeDrawnAreRefused) {
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
  EXPECT_THROW(Laparoscope(Oblique(), 0, 480), InputError);
}

}  // namespace
}  // namespace hpdm
