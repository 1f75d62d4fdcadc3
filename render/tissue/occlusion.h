#pragma once

#include <functional>

#include "render/camera/laparoscope.h"
#include "render/gl/gl_object.h"
#include "render/gl/shaders.h"

namespace hpdm {

/// How much of the light from everywhere the organs keep from each other: in the crease where two
/// touch, in a fold, around a dent. From the picture's own depth at half its resolution, so that it
/// follows every deformation.
///
/// A point is the more enclosed the nearer to the lens its surroundings are than itself (Luft,
/// Colditz and Deussen 2006). The inverse of the depth is linear on a plane seen in perspective, so
/// a pair of opposite neighbours on a plane averages to the point between them, whatever its slant:
/// what they exceed it by is the enclosure, without any normals. Differences beyond a few radii are
/// another surface's, far in front, and count for nothing. Render thread only.
class Occlusion {
 public:
  static constexpr double kRadius = 0.008;  ///< m on the organ, of the surroundings.

  /// Throws MachineError when the driver refuses the shader.
  Occlusion();

  /// Computes the occlusion of what `draw_depth` draws as seen by the scope. Leaves the framebuffer
  /// and the viewport as they were. Allocates only when the picture's size changes.
  void Update(const Laparoscope& scope, const std::function<void()>& draw_depth);

  /// Makes 1 - occlusion (0 to 1, by position in the picture) the texture of this unit.
  void Bind(int unit) const;

 private:
  void Resize(int width, int height);

  ShaderProgram program_;
  int sampling_;
  int inverse_depth_;
  int width_ = 0;  // of the half-size maps, px
  int height_ = 0;
  GlObject depth_{GlKind::kTexture};
  GlObject open_{GlKind::kTexture};
  GlObject depth_target_{GlKind::kFramebuffer};
  GlObject open_target_{GlKind::kFramebuffer};
  GlObject no_inputs_{GlKind::kVertexArray};
};

}  // namespace hpdm
