#pragma once

#include <memory>
#include <string>

#include "render/gl/render_context.h"

namespace hpdm {

/// An OpenGL core context (3.3 or newer) without a window or display. Only egl_context.cc calls
/// EGL. Pictures are drawn into framebuffer objects (picture_target.h).
///
/// Construct it on the thread that draws. A software renderer starts its workers in the
/// constructor, and they inherit that thread's scheduling class and core set, which must not be a
/// real-time loop's.
class EglContext : public RenderContext {
 public:
  /// Creates the context and makes it current on the calling thread. Tries in order: Mesa's
  /// surfaceless platform, each device of EGL_EXT_device_enumeration (vendors' drivers), the
  /// default display. Throws MachineError with each failure's reason and the remedy.
  EglContext();
  /// Call on the constructing thread. Destroys the context but leaves the display initialised,
  /// because other contexts of the process share it.
  ~EglContext() override;
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;

  const std::string& renderer() const override { return renderer_; }
  std::string Failure() const override;
  bool MakeCurrent() override;
  /// Does nothing, because there is no screen.
  void Present(const PictureTarget& /*picture*/, int /*width*/, int /*height*/) override {}

 private:
  bool TryDisplay(void* display, std::string* reason);
  void Release();

  void* display_ = nullptr;  // EGLDisplay
  void* context_ = nullptr;  // EGLContext
  void* surface_ = nullptr;  // EGLSurface, for drivers that need one
  bool reports_resets_ = false;
  std::string renderer_;
};

/// Returns an EglContext.
std::unique_ptr<RenderContext> HeadlessContext();

}  // namespace hpdm
