#include "render/gl/texture.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "engine/base/check.h"
#include "engine/base/error.h"

namespace hpdm {
namespace {

GLint WrapMode(Texture::Border border) {
  switch (border) {
    case Texture::Border::kRepeat:
      return GL_REPEAT;
    case Texture::Border::kMirror:
      return GL_MIRRORED_REPEAT;
    case Texture::Border::kClamp:
      return GL_CLAMP_TO_EDGE;
  }
  return GL_REPEAT;
}

}  // namespace

Texture::Texture(const Image& image, Border border) {
  HPDM_CHECK(image.width > 0 && image.height > 0);
  GLint limit = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &limit);
  if (std::max(image.width, image.height) > limit) {
    throw MachineError("OpenGL: no texture of " + std::to_string(image.width) + "x" +
                       std::to_string(image.height) + " pixels; give a picture of at most " +
                       std::to_string(limit) + " on a side");
  }
  // OpenGL's first row is the bottom one.
  const std::size_t row_bytes = std::size_t{3} * static_cast<std::size_t>(image.width);
  std::vector<std::uint8_t> rows;
  rows.reserve(image.rgb.size());
  for (int y = image.height - 1; y >= 0; --y) {
    rows.insert(rows.end(), image.At(0, y), image.At(0, y) + row_bytes);
  }
  glBindTexture(GL_TEXTURE_2D, texture_.name());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_SRGB8_ALPHA8, image.width, image.height, 0, GL_RGB,
               GL_UNSIGNED_BYTE, rows.data());
  SetSampling(border);
}

Texture::Texture(const Texels& texels) {
  glBindTexture(GL_TEXTURE_2D, texture_.name());
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, texels.width, texels.height, 0, GL_RGBA,
               GL_UNSIGNED_BYTE, texels.rgba.data());
  SetSampling(Border::kRepeat);
}

void Texture::SetSampling(Border border) {
  glGenerateMipmap(GL_TEXTURE_2D);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, WrapMode(border));
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, WrapMode(border));
}

void Texture::Bind(int unit) const {
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(GL_TEXTURE_2D, texture_.name());
}

}  // namespace hpdm
