#pragma once

#include <Eigen/Core>

#include "engine/snapshots.h"
#include "render/camera/laparoscope.h"
#include "render/gl/gl_object.h"

namespace hpdm {

/// Inputs of every program of a frame, in the std140 layout of the uniform block Frame
/// (frame.glsl). World coordinates in metres; pixels from the picture's bottom left.
struct FrameUniforms {
  Eigen::Matrix4f clip_from_world;
  Eigen::Vector4f lens_W;   ///< Position.
  Eigen::Vector4f light_W;  ///< Position; w: intensity, m^2.
  Eigen::Vector4f axis_W;   ///< Unit viewing axis.
  Eigen::Vector4f right_W;  ///< The ray of clip position (x, y) is axis + x right + y up.
  Eigen::Vector4f up_W;
  Eigen::Vector4f circle_px;                     ///< Centre, radius, width of the soft edge.
  Eigen::Vector4f tool_tip_W[kMaxInstruments];   ///< Position; w: radius of the tip, 0 without a
                                                 ///< tool.
  Eigen::Vector4f tool_axis_W[kMaxInstruments];  ///< Unit, from the tip along the shaft; w: radius
                                                 ///< of the shaft.
};
static_assert(sizeof(FrameUniforms) == 64 + 16 * (6 + 2 * kMaxInstruments));

/// Returns the scope's part of the uniforms; the tools' radii are 0.
FrameUniforms ScopeUniforms(const Laparoscope& scope);

/// Returns (v.x, v.y, v.z, w).
Eigen::Vector4f WithW(const Vector3d& v, double w);

/// The uniform block Frame on the graphics card. Render thread only.
class FrameBlock {
 public:
  static constexpr unsigned kBinding = 0;

  FrameBlock();
  /// Replaces the block's contents and binds it to kBinding. Allocates nothing.
  void Upload(const FrameUniforms& uniforms);

 private:
  GlObject buffer_{GlKind::kBuffer};
};

}  // namespace hpdm
