#pragma once

#include <utility>

namespace hpdm {

enum class GlKind { kBuffer, kVertexArray, kFramebuffer, kRenderbuffer, kProgram, kTexture };

/// Owns one OpenGL object. Created, used and destroyed on the thread of its context.
class GlObject {
 public:
  explicit GlObject(GlKind kind);
  ~GlObject();
  GlObject(GlObject&& other) noexcept : kind_(other.kind_), name_(std::exchange(other.name_, 0)) {}
  GlObject& operator=(GlObject&& other) noexcept {
    std::swap(kind_, other.kind_);
    std::swap(name_, other.name_);
    return *this;
  }

  unsigned name() const { return name_; }

 private:
  GlKind kind_;
  unsigned name_ = 0;
};

}  // namespace hpdm
