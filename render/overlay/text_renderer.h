#pragma once

#include <optional>
#include <vector>

#include "render/gl/gl_object.h"
#include "render/gl/shaders.h"
#include "render/overlay/text_layout.h"

namespace hpdm {

/// Draws text over the framebuffer that is bound. Render thread only.
class TextRenderer {
 public:
  /// Throws MachineError when the driver refuses the shader.
  TextRenderer();

  /// Draws `text` on a picture of width x height pixels, whose size decides the text's. Throws
  /// MachineError when the font cannot be drawn in a new size; leaves OpenGL's state as it was.
  void Draw(const StatusText& text, int width, int height);

 private:
  struct Vertex {
    float x, y;  // of the picture, px, y down
    float u, v;  // of the atlas, px
    float colour[4];
  };
  void UseSize(int pixels);

  ShaderProgram program_;
  int picture_size_;
  int atlas_size_;
  GlObject inputs_{GlKind::kVertexArray};
  GlObject vertices_{GlKind::kBuffer};
  GlObject texture_{GlKind::kTexture};
  std::optional<GlyphAtlas> atlas_;
  std::vector<Vertex> corners_;
};

}  // namespace hpdm
