#pragma once

#include <memory>
#include <string>

#include "render/gl/render_context.h"

namespace hpdm {

/// An OpenGL core context (3.3 or newer) that needs no window and no display: the only place of
/// the project that calls EGL. Pictures are drawn into framebuffer objects (picture_target.h).
///
/// A context belongs to the thread that constructs it, which is the one that draws: a software
/// renderer starts its workers inside the constructor, and they inherit that thread's scheduling
/// class and core set, which must be the render loop's and not a real-time loop's.
class EglContext : public RenderContext {
 public:
  /// Creates the context and makes it current on the calling thread. Displays tried in turn:
  /// Mesa's surfaceless platform, each device of EGL_EXT_device_enumeration (vendors' drivers),
  /// the default display. Throws MachineError naming what each one lacked and the remedy.
  EglContext();
  /// The constructing thread only. Destroys the context and leaves the display initialised, since
  /// other contexts of the process share it.
  ~EglContext() override;
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;

  const std::string& renderer() const override { return renderer_; }
  std::string Failure() const override;
  bool MakeCurrent() override;
  /// There is no screen.
  void Present(const PictureTarget& /*picture*/, int /*width*/, int /*height*/) override {}

 private:
  bool TryDisplay(void* display, std::string* reason);
  void Release();

  void* display_ = nullptr;  // EGLDisplay
  void* context_ = nullptr;  // EGLContext
  void* surface_ = nullptr;  // EGLSurface, where the driver cannot do without one
  bool reports_resets_ = false;
  std::string renderer_;
};

/// Makes an EglContext.
std::unique_ptr<RenderContext> HeadlessContext();

}  // namespace hpdm
