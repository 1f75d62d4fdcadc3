#pragma once

#include <string>
#include <vector>

#include "render/gl/gl_object.h"

namespace hpdm {

/// A linked OpenGL program. Render thread only.
class ShaderProgram {
 public:
  /// Compiles and links. The parts of a stage (shader_sources.h) are joined in order after the
  /// version line. Throws MachineError with the program's name, the stage and the driver's log in
  /// one line. `captured`: outputs of the vertex stage that transform feedback writes, one buffer
  /// each; such a program needs no fragment stage.
  ShaderProgram(std::string name, const std::vector<const char*>& vertex_parts,
                const std::vector<const char*>& fragment_parts,
                const std::vector<const char*>& captured = {});

  void Use() const;
  /// Returns the location of a uniform for glUniform*. An unknown name is a bug.
  int Uniform(const char* uniform) const;
  /// Connects a uniform block to a binding point. An unknown name is a bug.
  void BindBlock(const char* block, unsigned binding) const;
  /// Connects a sampler to a texture unit and calls Use(). An unknown name is a bug.
  void BindTexture(const char* sampler, int unit) const;

 private:
  std::string name_;
  GlObject program_{GlKind::kProgram};
};

}  // namespace hpdm
