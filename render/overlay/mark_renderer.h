#pragma once

#include <Eigen/Core>
#include <vector>

#include "render/gl/gl_object.h"
#include "render/gl/shaders.h"
#include "render/image/colour.h"

namespace hpdm {

/// A stroke between two points of the world with round ends, as wide on the screen wherever it is:
/// a line, a point (both ends alike), an arrow's head (one radius 0).
struct Mark {
  Eigen::Vector3f a_W = Eigen::Vector3f::Zero();  ///< m.
  float radius_a = 1;                             ///< px.
  Eigen::Vector3f b_W = Eigen::Vector3f::Zero();  ///< m.
  float radius_b = 1;                             ///< px.
  Colour colour = Colour::Ones();
  float opacity = 1;
};
using Marks = std::vector<Mark>;

/// Draws marks over a finished picture. Render thread only.
class MarkRenderer {
 public:
  /// Throws MachineError when the driver refuses the shader.
  MarkRenderer();

  /// Draws the marks in their order, within the circular picture; what lies behind something that
  /// was drawn has `hidden` (0..1) of its opacity. Marks fade
  /// from the distance `fade_from` (m, along the viewing axis) on, to a fifth at 1.4 times of it.
  /// Needs the frame's uniform
  /// block bound, and the picture's depths, which stay.
  void Draw(const Marks& marks, float hidden, double fade_from);

 private:
  ShaderProgram program_;
  int opacity_, fade_from_;
  GlObject layout_{GlKind::kVertexArray};
  GlObject buffer_{GlKind::kBuffer};
};

}  // namespace hpdm
