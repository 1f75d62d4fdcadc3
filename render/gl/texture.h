#pragma once

#include <cstdint>
#include <vector>

#include "render/gl/gl_object.h"
#include "render/image/image_file.h"

namespace hpdm {

/// A table of numbers for shaders: 4 bytes a texel, each 0..1, rows from the bottom up.
struct Texels {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgba;  ///< 4 width height bytes.
};

/// A picture on the graphics card, with mipmaps. Texture coordinate (0, 0) is its bottom left
/// corner, (1, 1) its top right one. Render thread only.
class Texture {
 public:
  enum class Border { kRepeat, kMirror, kClamp };

  /// Uploads an sRGB picture; shaders read linear light. An empty picture is a bug. Throws
  /// MachineError if a side exceeds the driver's limit.
  explicit Texture(const Image& image, Border border = Border::kRepeat);

  /// Uploads a repeating table without colour conversion.
  explicit Texture(const Texels& texels);

  /// Binds it to a texture unit.
  void Bind(int unit) const;

 private:
  void SetSampling(Border border);

  GlObject texture_{GlKind::kTexture};
};

}  // namespace hpdm
