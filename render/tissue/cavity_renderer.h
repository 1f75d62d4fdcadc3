#pragma once

#include <Eigen/Core>
#include <optional>

#include "render/camera/laparoscope.h"
#include "render/gl/gl_object.h"
#include "render/gl/shaders.h"
#include "render/gl/texture.h"
#include "render/image/image_file.h"

namespace hpdm {

/// The abdomen's wall, behind everything: the inside of a sphere about the first frame's target
/// that holds its scope. A background picture lies on it as a slide projector at the first frame's
/// lens throws it, its shorter side across the circle, mirrored beyond its border: it fills the
/// picture at the start and stays on the wall when the scope moves. Without one the wall is bare,
/// in soft folds. Render thread only.
class CavityRenderer {
 public:
  /// `background` may be null and need not outlive the call. Throws MachineError when the driver
  /// refuses the shader.
  explicit CavityRenderer(const Image* background);
  /// Fills what is not covered yet. The first call places the wall and the projector.
  void Draw(const Laparoscope& scope);

 private:
  void Place(const Laparoscope& scope);

  ShaderProgram program_;
  bool has_picture_;
  std::optional<Texture> texture_;  // the background, or else the relief of the bare wall
  Eigen::Vector2f slide_size_ = Eigen::Vector2f::Ones();  // in radii of the circle
  bool placed_ = false;
  GlObject no_inputs_{GlKind::kVertexArray};
};

}  // namespace hpdm
