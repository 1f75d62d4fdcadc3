#pragma once

#include <Eigen/Core>
#include <vector>

#include "render/gl/gl_object.h"
#include "render/gl/shaders.h"
#include "render/image/colour.h"

namespace hpdm {

/// A stroke between two points of the world with round ends and a constant width on the screen: a
/// line, a point (equal ends), or an arrow's head (one radius 0).
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
  /// Throws MachineError if the driver refuses the shader.
  MarkRenderer();

  /// Draws the marks in order, within the circular picture. Hidden parts have `hidden` (0..1) of
  /// their opacity. Marks beyond the distance `fade_from` (m, along the viewing axis) fade to a
  /// fifth at 1.4 times that distance. Needs the frame's uniform block bound and the picture's
  /// depth buffer, which it keeps.
  void Draw(const Marks& marks, float hidden, double fade_from);

 private:
  ShaderProgram program_;
  int opacity_, fade_from_;
  GlObject layout_{GlKind::kVertexArray};
  GlObject buffer_{GlKind::kBuffer};
};

}  // namespace hpdm
