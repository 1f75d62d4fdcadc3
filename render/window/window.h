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
/// thread. Only window.cc includes GLFW and X11. At most one exists at a time.
///
///     main thread:    Window -> WaitForEvents, CaptureCursor ...               -> ~Window
///     render thread:            MakeContext -> MakeCurrent, draw, Present -> ~RenderContext
///
/// The session survives the loss of the display, if its server ends or the connection breaks.
/// lost() then becomes true, the context reports a failure, and the window does nothing more.
class Window {
 public:
  /// Throws MachineError, as the constructor does, if no display can be reached. Main thread, while
  /// there is no window.
  static void RequireDisplay();

  /// Opens a window with an OpenGL 3.3 core context through EGL. Its framebuffer has the given size
  /// (px) unless the window manager decides otherwise; the first ResizeEvent has the real one.
  /// Throws MachineError with a remedy if there is no display or no such context. Main thread.
  Window(int width, int height, const std::string& title);
  /// Call on the main thread after the render thread has ended.
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  /// Waits at most `seconds` for an event and returns the events since the last call, in order. The
  /// first call reports the window's size. Main thread.
  std::vector<WindowEvent> WaitForEvents(double seconds);

  /// Captures the cursor (hidden, moving without limits) or releases it. Main thread.
  void CaptureCursor(bool on);

  /// True after the display was lost. Any thread.
  bool lost() const { return lost_.stop_requested(); }

  /// Makes the window's context current on the calling thread, which becomes the render thread.
  std::unique_ptr<RenderContext> MakeContext();

 private:
  class Context;
  struct Callbacks;

  static void StartGlfw();
  void Open(int width, int height, const std::string& title);
  void Report(const WindowEvent& event) { events_.push_back(event); }
  void ReportSize();
  void ReportGamepad();

  GLFWwindow* window_ = nullptr;
  bool reports_resets_ = false;  // the context notifies of resets
  std::stop_source lost_;        // requested by the thread that finds the display lost
  std::vector<WindowEvent> events_;
  bool captured_ = false;
  bool has_gamepad_ = false;  // at the last report
  bool has_cursor_ = false;   // cursor_x_ and cursor_y_ hold the last reported position
  double cursor_x_ = 0;
  double cursor_y_ = 0;
};

}  // namespace hpdm
