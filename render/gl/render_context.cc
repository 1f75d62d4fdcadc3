#include "render/gl/render_context.h"

#include <epoxy/gl.h>

namespace hpdm {
namespace {

const char* GlErrorName(GLenum error) {
  switch (error) {
    case GL_INVALID_ENUM:
      return "GL_INVALID_ENUM";
    case GL_INVALID_VALUE:
      return "GL_INVALID_VALUE";
    case GL_INVALID_OPERATION:
      return "GL_INVALID_OPERATION";
    case GL_INVALID_FRAMEBUFFER_OPERATION:
      return "GL_INVALID_FRAMEBUFFER_OPERATION";
    case GL_OUT_OF_MEMORY:
      return "GL_OUT_OF_MEMORY";
    case GL_CONTEXT_LOST:
      return "GL_CONTEXT_LOST";
    default:
      return "an unknown GL error";
  }
}

}  // namespace

bool IsSoftwareRenderer(std::string_view renderer) {
  for (const char* software : {"llvmpipe", "softpipe", "SWR", "SwiftShader"}) {
    if (renderer.find(software) != std::string_view::npos) return true;
  }
  return false;
}

std::string GlRenderer() {
  const int version = epoxy_gl_version();  // major * 10 + minor
  const auto* renderer = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  return std::string(renderer != nullptr ? renderer : "unknown renderer") + ", OpenGL " +
         std::to_string(version / 10) + "." + std::to_string(version % 10);
}

std::string GlFailure(bool reports_resets) {
  // The query exists since OpenGL 4.5.
  if (reports_resets && epoxy_gl_version() >= 45 && glGetGraphicsResetStatus() != GL_NO_ERROR) {
    return "the OpenGL context was lost: the graphics processor was reset";
  }
  const GLenum error = glGetError();
  if (error == GL_NO_ERROR) return {};
  // A context may hold several flags; a lost one reports forever, hence the bound.
  for (int i = 0; i < 8 && glGetError() != GL_NO_ERROR; ++i) {
  }
  return std::string("OpenGL reported ") + GlErrorName(error);
}

}  // namespace hpdm
