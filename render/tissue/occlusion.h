#pragma once

#include <functional>

#include "render/camera/laparoscope.h"
#include "render/gl/gl_object.h"
#include "render/gl/shaders.h"

namespace hpdm {

/// Ambient occlusion of the organs: in the crease where two touch, in a fold, around a dent. It
/// uses the picture's depth at half resolution, so it follows every deformation. Render thread
/// only.
///
/// Method (after Luft, Colditz and Deussen 2006): a point is more enclosed the nearer to the lens
/// its surroundings are. The inverse depth is linear on a plane in perspective, so two opposite
/// neighbours on a plane of any slant average to the point between them. Their excess over it is
/// the enclosure, without normals. Differences beyond a few radii belong to another surface far in
/// front and are ignored.
class Occlusion {
 public:
  static constexpr double kRadius = 0.008;  ///< Radius of the surroundings, m on the organ.

  /// Throws MachineError if the driver refuses the shader.
  Occlusion();

  /// Computes the occlusion of the surfaces that `draw_depth` draws, as seen by the scope. Restores
  /// the framebuffer and the viewport. Allocates only if the picture's size changes.
  void Update(const Laparoscope& scope, const std::function<void()>& draw_depth);

  /// Binds 1 - occlusion (0 to 1, by position in the picture) to a texture unit.
  void Bind(int unit) const;

 private:
  void Resize(int width, int height);

  ShaderProgram program_;
  int sampling_;
  int inverse_depth_;
  int width_ = 0;  // size of the half-size maps, px
  int height_ = 0;
  GlObject depth_{GlKind::kTexture};
  GlObject open_{GlKind::kTexture};
  GlObject depth_target_{GlKind::kFramebuffer};
  GlObject open_target_{GlKind::kFramebuffer};
  GlObject no_inputs_{GlKind::kVertexArray};
};

}  // namespace hpdm
