#pragma once

#include <Eigen/Core>
#include <optional>

#include "render/camera/laparoscope.h"
#include "render/gl/gl_object.h"
#include "render/gl/shaders.h"
#include "render/gl/texture.h"
#include "render/image/image_file.h"

namespace hpdm {

/// Draws the abdominal wall behind everything: the inside of a sphere about the first frame's
/// target that contains its scope. Render thread only.
///
/// A background picture is projected onto the wall from the first frame's lens, its shorter side
/// across the circle, mirrored beyond its border. It fills the picture at the start and stays on
/// the wall when the scope moves. Without one the wall has soft folds.
class CavityRenderer {
 public:
  /// `background` may be null and need not outlive the call. Throws MachineError if the driver
  /// refuses the shader.
  explicit CavityRenderer(const Image* background);
  /// Fills the pixels that nothing covers. The first call places the wall and the projector.
  void Draw(const Laparoscope& scope);

 private:
  void Place(const Laparoscope& scope);

  ShaderProgram program_;
  bool has_picture_;
  std::optional<Texture> texture_;  // the background, or the relief of the bare wall
  Eigen::Vector2f slide_size_ = Eigen::Vector2f::Ones();  // in radii of the circle
  bool placed_ = false;
  GlObject no_inputs_{GlKind::kVertexArray};
};

}  // namespace hpdm
