#include "render/overlay/text_renderer.h"

#include <epoxy/gl.h>

#include <cstddef>

#include "render/shader_sources.h"

namespace hpdm {
TextRenderer::TextRenderer()
    : program_("text", {glsl::kTextVertex}, {glsl::kTextFragment}),
      picture_size_(program_.Uniform("picture_size")),
      atlas_size_(program_.Uniform("atlas_size")) {
  glBindVertexArray(inputs_.name());
  glBindBuffer(GL_ARRAY_BUFFER, vertices_.name());
  const auto input = [](GLuint place, GLint count, std::size_t offset) {
    glEnableVertexAttribArray(place);
    glVertexAttribPointer(place, count, GL_FLOAT, GL_FALSE, sizeof(Vertex),
                          reinterpret_cast<const void*>(offset));
  };
  input(0, 2, offsetof(Vertex, x));
  input(1, 2, offsetof(Vertex, u));
  input(2, 4, offsetof(Vertex, colour));
  glBindVertexArray(0);
}

void TextRenderer::UseSize(int pixels) {
  if (atlas_ && atlas_->pixels() == pixels) return;
  atlas_.emplace(pixels);
  glBindTexture(GL_TEXTURE_2D, texture_.name());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_R8, atlas_->width(), atlas_->height(), 0, GL_RED,
               GL_UNSIGNED_BYTE, atlas_->coverage().data());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  // Glyphs are drawn pixel by pixel, without interpolation.
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

void TextRenderer::Draw(const StatusText& text, int width, int height, Palette palette) {
  glActiveTexture(GL_TEXTURE0);
  UseSize(TextPixels(width, height));
  corners_.clear();
  for (const TextQuad& quad : LayOut(text, *atlas_, width, height, palette)) {
    // Two triangles.
    for (const auto& [right, below] : {std::pair{0, 0}, {0, 1}, {1, 0}, {1, 0}, {0, 1}, {1, 1}}) {
      const Eigen::Vector4f& colour = quad.colour;
      corners_.push_back({static_cast<float>(quad.x + right * quad.width),
                          static_cast<float>(quad.y + below * quad.height),
                          static_cast<float>(quad.atlas_x + right * quad.atlas_width),
                          static_cast<float>(quad.atlas_y + below * quad.atlas_height),
                          {colour[0], colour[1], colour[2], colour[3]}});
    }
  }
  if (corners_.empty()) return;

  program_.Use();
  glUniform2f(picture_size_, static_cast<float>(width), static_cast<float>(height));
  glUniform2f(atlas_size_, static_cast<float>(atlas_->width()),
              static_cast<float>(atlas_->height()));
  glBindTexture(GL_TEXTURE_2D, texture_.name());
  glBindVertexArray(inputs_.name());
  glBindBuffer(GL_ARRAY_BUFFER, vertices_.name());
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(corners_.size() * sizeof(Vertex)),
               corners_.data(), GL_STREAM_DRAW);
  glDisable(GL_DEPTH_TEST);
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(corners_.size()));
  glDisable(GL_BLEND);
  glEnable(GL_DEPTH_TEST);
}

}  // namespace hpdm
