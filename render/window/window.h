#pragma once

#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "render/gl/render_context.h"
#include "render/window/window_event.h"

struct GLFWwindow;

namespace hpdm {

/// A window on the user's screen: its input for the main thread, its OpenGL context for the render
/// thread. The only place of the project that knows GLFW and X11. One at a time.
///
///     main thread:    Window -> WaitForEvents, CaptureCursor ...               -> ~Window
///     render thread:            MakeContext -> MakeCurrent, draw, Present -> ~RenderContext
///
/// A display that goes away (its server ends, the connection breaks) ends neither the program nor
/// the session: lost() becomes true, the context reports a failure, and the window does nothing
/// more.
class Window {
 public:
  /// Opens a window whose framebuffer has the given size (px; the user's window manager may decide
  /// otherwise, see the first ResizeEvent) with an OpenGL 3.3 core context through EGL. Main
  /// thread. Throws MachineError without a display, or when it offers no such context, with the
  /// remedy.
  Window(int width, int height, const std::string& title);
  /// Main thread, after the render thread has ended.
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  /// What has happened since the last call, in order; waits for something to happen, at most
  /// `seconds`. The first call reports the window's size. Main thread.
  std::vector<WindowEvent> WaitForEvents(double seconds);

  /// Hides the cursor and lets it move without end, so that only its motion counts; or lets it go.
  /// Main thread.
  void CaptureCursor(bool on);

  /// The display has gone away. Any thread.
  bool lost() const { return lost_.stop_requested(); }

  /// The window's context, made current on the calling thread, which becomes the render thread.
  std::unique_ptr<RenderContext> MakeContext();

 private:
  class Context;
  struct Callbacks;

  void Open(int width, int height, const std::string& title);
  void Report(const WindowEvent& event) { events_.push_back(event); }
  void ReportSize();

  GLFWwindow* window_ = nullptr;
  bool reports_resets_ = false;  // its context does
  std::stop_source lost_;        // requested by whichever thread finds the display gone
  std::vector<WindowEvent> events_;
  bool captured_ = false;
  bool has_cursor_ = false;  // the two below are those of the last report
  double cursor_x_ = 0;
  double cursor_y_ = 0;
};

}  // namespace hpdm
