#include "render/camera/frame_uniforms.h"

#include <epoxy/gl.h>

#include <algorithm>

namespace hpdm {
namespace {

constexpr double kSoftEdge = 0.012;  // of the circle's radius
static_assert(kMaxInstruments == 4, "kMaxTools of frame.glsl");

}  // namespace

Eigen::Vector4f WithW(const Vector3d& v, double w) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z()),
          static_cast<float>(w)};
}

FrameUniforms ScopeUniforms(const Laparoscope& scope) {
  FrameUniforms frame;
  const Vector3d axis_W = scope.ViewingAxis_W();
  const double distance = scope.target_distance();
  const double focal = scope.focal_length_px();
  frame.clip_from_world = scope.ClipFromWorld().cast<float>();
  frame.lens_W = WithW(scope.X_WC().translation(), 0);
  frame.light_W = WithW(scope.p_light_W(), distance * distance);
  frame.axis_W = WithW(axis_W, 0);
  frame.right_W = WithW(scope.X_WC().linear().col(0) * (scope.width() / (2 * focal)), 0);
  frame.up_W = WithW(scope.X_WC().linear().col(1) * (scope.height() / (2 * focal)), 0);
  frame.circle_px =
      Eigen::Vector4d(0.5 * scope.width(), 0.5 * scope.height(), scope.circle_radius_px(),
                      std::max(1.5, kSoftEdge * scope.circle_radius_px()))
          .cast<float>();
  for (int t = 0; t < kMaxInstruments; ++t) {
    frame.tool_tip_W[t].setZero();
    frame.tool_axis_W[t] = Eigen::Vector4f::UnitZ();
  }
  return frame;
}

FrameBlock::FrameBlock() {
  glBindBuffer(GL_UNIFORM_BUFFER, buffer_.name());
  glBufferData(GL_UNIFORM_BUFFER, sizeof(FrameUniforms), nullptr, GL_DYNAMIC_DRAW);
}

void FrameBlock::Upload(const FrameUniforms& uniforms) {
  glBindBuffer(GL_UNIFORM_BUFFER, buffer_.name());
  glBufferSubData(GL_UNIFORM_BUFFER, 0, sizeof uniforms, &uniforms);
  glBindBufferBase(GL_UNIFORM_BUFFER, kBinding, buffer_.name());
}

}  // namespace hpdm
