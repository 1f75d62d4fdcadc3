#pragma once

#include "render/gl_object.h"
#include "render/image_file.h"

namespace hpdm {

/// A picture on the graphics card, with mipmaps. Texture coordinate (0, 0) is its bottom left
/// corner, (1, 1) its top right one. Render thread only.
class Texture {
 public:
  enum class Border { kRepeat, kMirror, kClamp };

  /// Uploads an sRGB picture: shaders read linear light. An empty picture is a bug. Throws
  /// MachineError when a side exceeds the driver's limit.
  explicit Texture(const Image& image, Border border = Border::kRepeat);

  /// Makes it the texture that samplers of this unit read.
  void Bind(int unit) const;

 private:
  GlObject texture_{GlKind::kTexture};
};

}  // namespace hpdm
