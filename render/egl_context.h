#pragma once

#include <string>

namespace hpdm {

/// An OpenGL core context (3.3 or newer) that needs no window and no display: the only place of
/// the project that knows EGL. Pictures are drawn into framebuffer objects (picture_target.h).
///
/// A context belongs to the thread that constructs it, which is the one that draws: a software
/// renderer starts its workers inside the constructor, and they inherit that thread's scheduling
/// class and core set, which must be the render loop's and not a real-time loop's.
class EglContext {
 public:
  /// Creates the context and makes it current on the calling thread. Displays tried in turn:
  /// Mesa's surfaceless platform, each device of EGL_EXT_device_enumeration (vendors' drivers),
  /// the default display. Throws MachineError naming what each one lacked and the remedy.
  EglContext();
  /// The constructing thread only. Destroys the context and leaves the display initialised, since
  /// other contexts of the process share it.
  ~EglContext();
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;

  /// The GL renderer and version, such as "llvmpipe (LLVM 15.0.6, 256 bits), 4.5".
  const std::string& renderer() const { return renderer_; }

  /// Whether drawing still reaches this context: it is current on the calling thread, was not
  /// reset, and GL has recorded no error. Otherwise one line that says what happened; empty when
  /// all is well. Clears GL's error flags. Waits for nothing.
  std::string Failure() const;

  /// Makes the context current on the constructing thread again, after other code has taken it
  /// away; false when EGL refuses. GL objects must not be deleted without a current context.
  bool MakeCurrent();

 private:
  bool TryDisplay(void* display, std::string* reason);
  void Release();

  void* display_ = nullptr;  // EGLDisplay
  void* context_ = nullptr;  // EGLContext
  void* surface_ = nullptr;  // EGLSurface, where the driver cannot do without one
  bool reports_resets_ = false;
  std::string renderer_;
};

}  // namespace hpdm
