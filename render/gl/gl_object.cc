#include "render/gl/gl_object.h"

#include <epoxy/gl.h>

namespace hpdm {

GlObject::GlObject(GlKind kind) : kind_(kind) {
  switch (kind_) {
    case GlKind::kBuffer:
      glGenBuffers(1, &name_);
      break;
    case GlKind::kVertexArray:
      glGenVertexArrays(1, &name_);
      break;
    case GlKind::kFramebuffer:
      glGenFramebuffers(1, &name_);
      break;
    case GlKind::kRenderbuffer:
      glGenRenderbuffers(1, &name_);
      break;
    case GlKind::kProgram:
      name_ = glCreateProgram();
      break;
    case GlKind::kTexture:
      glGenTextures(1, &name_);
      break;
  }
}

GlObject::~GlObject() {
  if (name_ == 0) return;
  switch (kind_) {
    case GlKind::kBuffer:
      glDeleteBuffers(1, &name_);
      break;
    case GlKind::kVertexArray:
      glDeleteVertexArrays(1, &name_);
      break;
    case GlKind::kFramebuffer:
      glDeleteFramebuffers(1, &name_);
      break;
    case GlKind::kRenderbuffer:
      glDeleteRenderbuffers(1, &name_);
      break;
    case GlKind::kProgram:
      glDeleteProgram(name_);
      break;
    case GlKind::kTexture:
      glDeleteTextures(1, &name_);
      break;
  }
}

}  // namespace hpdm
