#pragma once

#include <optional>
#include <vector>

#include "render/gl/gl_object.h"
#include "render/gl/shaders.h"
#include "render/overlay/text_layout.h"

namespace hpdm {

/// Draws text over the bound framebuffer. Render thread only.
class TextRenderer {
 public:
  /// Throws MachineError if the driver refuses the shader.
  TextRenderer();

  /// Draws `text` on a picture of width x height pixels; the text's size follows the picture's.
  /// Leaves OpenGL's state unchanged. Throws MachineError if the font cannot be drawn in a new
  /// size.
  void Draw(const StatusText& text, int width, int height, Palette palette = Palette::kStandard);

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
