#include "render/camera/picture_target.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <string>

#include "engine/base/check.h"
#include "engine/base/error.h"
#include "render/camera/laparoscope.h"
#include "render/gl/render_context.h"

namespace hpdm {
namespace {

void RequireComplete(int width, int height) {
  if (glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE) return;
  throw MachineError("OpenGL: no framebuffer of " + std::to_string(width) + "x" +
                     std::to_string(height) + " pixels; give a smaller picture size");
}

}  // namespace

int PictureTarget::UsualSamples() {
  return IsSoftwareRenderer(reinterpret_cast<const char*>(glGetString(GL_RENDERER))) ? 1 : 4;
}

PictureTarget::PictureTarget(int width, int height, int samples)
    : width_(width),
      height_(height),
      multisampled_((samples == 0 ? UsualSamples() : samples) > 1),
      lens_(multisampled_ ? LensPass::Edges::kAsDrawn : LensPass::Edges::kSmoothed),
      rgba_(std::size_t{4} * width * height) {
  glBindTexture(GL_TEXTURE_2D, pinhole_colour_.name());
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER}) {
    glTexParameteri(GL_TEXTURE_2D, filter, GL_LINEAR);
  }
  for (const GLenum direction : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T}) {
    glTexParameteri(GL_TEXTURE_2D, direction, GL_CLAMP_TO_EDGE);
  }
  glBindFramebuffer(GL_FRAMEBUFFER, pinhole_.name());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D,
                         pinhole_colour_.name(), 0);
  RequireComplete(width, height);

  GLint count = 0;
  if (multisampled_) {
    GLint max_samples = 1;
    glGetIntegerv(GL_MAX_SAMPLES, &max_samples);
    count = std::min<GLint>(samples == 0 ? UsualSamples() : samples, max_samples);
    glBindFramebuffer(GL_FRAMEBUFFER, drawn_.name());
    glBindRenderbuffer(GL_RENDERBUFFER, drawn_colour_.name());
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, count, GL_RGBA8, width, height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
                              drawn_colour_.name());
  }
  glBindRenderbuffer(GL_RENDERBUFFER, drawn_depth_.name());
  glRenderbufferStorageMultisample(GL_RENDERBUFFER, count, GL_DEPTH_COMPONENT24, width, height);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER,
                            drawn_depth_.name());
  RequireComplete(width, height);

  glBindFramebuffer(GL_FRAMEBUFFER, resolved_.name());
  glBindRenderbuffer(GL_RENDERBUFFER, resolved_colour_.name());
  glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, width, height);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
                            resolved_colour_.name());
  RequireComplete(width, height);
}

void PictureTarget::Bind() const {
  glBindFramebuffer(GL_FRAMEBUFFER, multisampled_ ? drawn_.name() : pinhole_.name());
  glViewport(0, 0, width_, height_);
}

void PictureTarget::Resolve(const Laparoscope& scope) const {
  const bool as_drawn = multisampled_ && scope.distortion() == 0;
  if (multisampled_) {
    glBindFramebuffer(GL_READ_FRAMEBUFFER, drawn_.name());
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, as_drawn ? resolved_.name() : pinhole_.name());
    glBlitFramebuffer(0, 0, width_, height_, 0, 0, width_, height_, GL_COLOR_BUFFER_BIT,
                      GL_NEAREST);
  }
  if (as_drawn) return;
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, resolved_.name());
  lens_.Draw(scope, pinhole_colour_);
}

void PictureTarget::ShowOnScreen(int width, int height) const {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, resolved_.name());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
  const ScreenPlace place = FitOnScreen(width_, height_, width, height);
  if (place.width != width || place.height != height) glClear(GL_COLOR_BUFFER_BIT);
  const bool same_size = place.width == width_ && place.height == height_;
  glBlitFramebuffer(0, 0, width_, height_, place.x, place.y, place.x + place.width,
                    place.y + place.height, GL_COLOR_BUFFER_BIT,
                    same_size ? GL_NEAREST : GL_LINEAR);
}

ScreenPlace FitOnScreen(int picture_width, int picture_height, int width, int height) {
  ScreenPlace place;
  // Compares the ratios of the sides without dividing.
  if (width * picture_height > height * picture_width) {
    place.height = height;
    place.width = height * picture_width / picture_height;
  } else {
    place.width = width;
    place.height = width * picture_height / picture_width;
  }
  place.x = (width - place.width) / 2;
  place.y = (height - place.height) / 2;
  return place;
}

void PictureTarget::Read(Image* image) {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, resolved_.name());
  // The framebuffer has four bytes a pixel; drivers convert to three slowly.
  glReadPixels(0, 0, width_, height_, GL_RGBA, GL_UNSIGNED_BYTE, rgba_.data());

  image->width = width_;
  image->height = height_;
  image->rgb.resize(std::size_t{3} * width_ * height_);
  std::uint8_t* out = image->rgb.data();
  for (int y = height_ - 1; y >= 0; --y) {
    const std::uint8_t* in = rgba_.data() + std::size_t{4} * width_ * y;
    for (int x = 0; x < width_; ++x, in += 4, out += 3) {
      out[0] = in[0];
      out[1] = in[1];
      out[2] = in[2];
    }
  }
}

void PictureTarget::ReadDepth(std::vector<float>* depth) const {
  HPDM_CHECK(!multisampled_);
  const auto row = static_cast<std::size_t>(width_);
  depth->resize(row * static_cast<std::size_t>(height_));
  glBindFramebuffer(GL_READ_FRAMEBUFFER, pinhole_.name());
  glReadPixels(0, 0, width_, height_, GL_DEPTH_COMPONENT, GL_FLOAT, depth->data());
  for (std::size_t low = 0, high = static_cast<std::size_t>(height_); low + 1 < high; ++low) {
    --high;
    std::swap_ranges(depth->data() + low * row, depth->data() + (low + 1) * row,
                     depth->data() + high * row);
  }
}

}  // namespace hpdm
