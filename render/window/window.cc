#include "render/window/window.h"

// Eigen before X11, whose macros break it.
#include "render/camera/picture_target.h"

// epoxy before GLFW, which then leaves OpenGL's own header out.
#include <epoxy/gl.h>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#define GLFW_EXPOSE_NATIVE_X11
#include <GLFW/glfw3native.h>

#include <cctype>
#include <cmath>
#include <utility>

#include "engine/base/check.h"
#include "engine/base/error.h"

namespace hpdm {
namespace {

/// Returns GLFW's last error. It is static because GLFW's error callback has no user pointer. Main
/// thread.
std::string& LastError() {
  static std::string text;
  return text;
}

[[noreturn]] void ThrowNoWindow() {
  const std::string why = LastError().empty() ? "no reason given" : LastError();
  throw MachineError("--window: no window can be opened (" + why +
                     "); --headless draws without one");
}

// Sticks rest up to a tenth off their middle.
double WithoutDrift(double axis) { return std::abs(axis) < 0.15 ? 0 : axis; }

int KeyOf(int key, int scancode) {
  switch (key) {
    case GLFW_KEY_ESCAPE:
      return kKeyEscape;
    case GLFW_KEY_TAB:
      return kKeyTab;
    case GLFW_KEY_F1:
      return kKeyF1;
    case GLFW_KEY_LEFT_SHIFT:
    case GLFW_KEY_RIGHT_SHIFT:
      return kKeyShift;
    case GLFW_KEY_LEFT:
      return kKeyLeft;
    case GLFW_KEY_RIGHT:
      return kKeyRight;
    case GLFW_KEY_UP:
      return kKeyUp;
    case GLFW_KEY_DOWN:
      return kKeyDown;
    case GLFW_KEY_PAGE_UP:
      return kKeyPageUp;
    case GLFW_KEY_PAGE_DOWN:
      return kKeyPageDown;
    case GLFW_KEY_HOME:
      return kKeyHome;
    case GLFW_KEY_BACKSPACE:
      return kKeyBackspace;
    case GLFW_KEY_SPACE:
      return ' ';
    default:
      break;
  }
  const char* label = glfwGetKeyName(key, scancode);
  if (label != nullptr && label[0] > 0 && label[1] == '\0') {
    return std::tolower(static_cast<unsigned char>(label[0]));
  }
  // GLFW's codes of printing keys are the ASCII codes of a US keyboard.
  return key > 0 && key < 0x80 ? std::tolower(key) : kKeyOther;
}

}  // namespace

/// GLFW calls these on the main thread, inside glfwWaitEventsTimeout.
struct Window::Callbacks {
  static Window& Of(GLFWwindow* window) {
    return *static_cast<Window*>(glfwGetWindowUserPointer(window));
  }
  static void Error(int /*code*/, const char* text) { LastError() = text; }
  static void Key(GLFWwindow* window, int key, int scancode, int action, int /*modifiers*/) {
    if (action == GLFW_REPEAT) return;
    Of(window).Report(KeyEvent{KeyOf(key, scancode), action == GLFW_PRESS});
  }
  static void Button(GLFWwindow* window, int button, int action, int /*modifiers*/) {
    if (button > GLFW_MOUSE_BUTTON_MIDDLE) return;
    const MouseButton which = button == GLFW_MOUSE_BUTTON_LEFT    ? MouseButton::kLeft
                              : button == GLFW_MOUSE_BUTTON_RIGHT ? MouseButton::kRight
                                                                  : MouseButton::kMiddle;
    Of(window).Report(ButtonEvent{which, action == GLFW_PRESS});
  }
  static void Cursor(GLFWwindow* window, double x, double y) {
    Window& self = Of(window);
    // x and y are screen coordinates, which on a high-density display span several pixels.
    int screen_width = 1, width = 1, unused = 0;
    glfwGetWindowSize(window, &screen_width, &unused);
    glfwGetFramebufferSize(window, &width, &unused);
    const double scale = screen_width > 0 ? static_cast<double>(width) / screen_width : 1;
    if (self.has_cursor_) {
      self.Report(MotionEvent{scale * (x - self.cursor_x_), scale * (y - self.cursor_y_)});
    }
    self.has_cursor_ = true;
    self.cursor_x_ = x;
    self.cursor_y_ = y;
  }
  static void Scroll(GLFWwindow* window, double /*x*/, double y) {
    Of(window).Report(WheelEvent{y});
  }
  static void Size(GLFWwindow* window, int width, int height) {
    Of(window).Report(ResizeEvent{width, height});
  }
  static void Focus(GLFWwindow* window, int focused) {
    Of(window).Report(FocusEvent{focused == GLFW_TRUE});
  }
  static void Close(GLFWwindow* window) { Of(window).Report(CloseEvent{}); }
  /// Replaces Xlib's handler, which ends the program. A failed request, such as one on a destroyed
  /// window, has no effect.
  static int RequestFailed(Display* /*display*/, XErrorEvent* /*error*/) { return 0; }
  /// When the connection to the display breaks, Xlib calls these two in order.
  static int DisplayFailed(Display* /*display*/) { return 0; }
  static void DisplayLost(Display* /*display*/, void* window) {
    static_cast<Window*>(window)->lost_.request_stop();
  }
};

/// The window's context on the render thread.
class Window::Context final : public RenderContext {
 public:
  explicit Context(Window* window) : window_(window) {
    if (!MakeCurrent()) throw MachineError("--window: the display was lost");
    // Waiting for the screen's refresh would delay the newest step by up to 17 ms. Without it a
    // picture may change while the screen shows it.
    glfwSwapInterval(0);
    renderer_ = GlRenderer();
  }
  ~Context() override {
    if (!window_->lost()) glfwMakeContextCurrent(nullptr);
  }
  const std::string& renderer() const override { return renderer_; }
  std::string Failure() const override {
    if (window_->lost()) return "the window's display was lost";
    if (glfwGetCurrentContext() != window_->window_) {
      return "the window's OpenGL context is no longer current on the render thread";
    }
    return GlFailure(window_->reports_resets_);
  }
  bool MakeCurrent() override {
    if (window_->lost()) return false;
    glfwMakeContextCurrent(window_->window_);
    return glfwGetCurrentContext() == window_->window_;
  }
  void Present(const PictureTarget& picture, int width, int height) override {
    if (width <= 0 || height <= 0 || window_->lost()) return;
    picture.ShowOnScreen(width, height);
    glfwSwapBuffers(window_->window_);
  }

 private:
  Window* window_;
  std::string renderer_;
};

void Window::StartGlfw() {
  LastError().clear();
  glfwSetErrorCallback(Callbacks::Error);
  if (glfwInit() != GLFW_TRUE) ThrowNoWindow();
}

void Window::RequireDisplay() {
  StartGlfw();
  glfwTerminate();
}

Window::Window(int width, int height, const std::string& title) {
  StartGlfw();
  Open(width, height, title);
  if (window_ == nullptr) {
    glfwTerminate();
    ThrowNoWindow();
  }
  if (Display* display = glfwGetX11Display(); display != nullptr) {
    XSetErrorHandler(Callbacks::RequestFailed);
    XSetIOErrorHandler(Callbacks::DisplayFailed);
    XSetIOErrorExitHandler(display, Callbacks::DisplayLost, this);
  }
  glfwSetWindowUserPointer(window_, this);
  glfwSetKeyCallback(window_, Callbacks::Key);
  glfwSetMouseButtonCallback(window_, Callbacks::Button);
  glfwSetCursorPosCallback(window_, Callbacks::Cursor);
  glfwSetScrollCallback(window_, Callbacks::Scroll);
  glfwSetFramebufferSizeCallback(window_, Callbacks::Size);
  glfwSetWindowFocusCallback(window_, Callbacks::Focus);
  glfwSetWindowCloseCallback(window_, Callbacks::Close);
  ReportSize();
  // GLFW reports errors on the thread that causes them, which later may be the render thread.
  glfwSetErrorCallback(nullptr);
}

void Window::Open(int width, int height, const std::string& title) {
  glfwWindowHint(GLFW_CONTEXT_CREATION_API, GLFW_EGL_CONTEXT_API);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  // Pictures are copied finished from another framebuffer.
  glfwWindowHint(GLFW_DEPTH_BITS, 0);
  glfwWindowHint(GLFW_STENCIL_BITS, 0);
  // First with notification of resets, as EglContext does.
  for (const int robustness : {GLFW_LOSE_CONTEXT_ON_RESET, GLFW_NO_ROBUSTNESS}) {
    glfwWindowHint(GLFW_CONTEXT_ROBUSTNESS, robustness);
    window_ = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
    reports_resets_ = robustness == GLFW_LOSE_CONTEXT_ON_RESET;
    if (window_ != nullptr) return;
  }
}

void Window::ReportSize() {
  ResizeEvent size;
  glfwGetFramebufferSize(window_, &size.width, &size.height);
  Report(size);
}

// GLFW knows gamepads as states without events, and also while another window has the focus.
void Window::ReportGamepad() {
  GLFWgamepadstate state;
  bool found = false;
  if (glfwGetWindowAttrib(window_, GLFW_FOCUSED) == GLFW_TRUE) {
    for (int pad = GLFW_JOYSTICK_1; pad <= GLFW_JOYSTICK_LAST && !found; ++pad) {
      found = glfwGetGamepadState(pad, &state) == GLFW_TRUE;
    }
  }
  if (found) {
    const auto stick = [&state](int axis) { return WithoutDrift(state.axes[axis]); };
    const auto pulled = [&state](int axis) { return 0.5 * (1 + double{state.axes[axis]}); };
    Report(GamepadEvent{
        .right = stick(GLFW_GAMEPAD_AXIS_LEFT_X),
        .up = -stick(GLFW_GAMEPAD_AXIS_LEFT_Y),
        .in = WithoutDrift(pulled(GLFW_GAMEPAD_AXIS_RIGHT_TRIGGER) -
                           pulled(GLFW_GAMEPAD_AXIS_LEFT_TRIGGER)),
        .roll = stick(GLFW_GAMEPAD_AXIS_RIGHT_X),
        .grip = state.buttons[GLFW_GAMEPAD_BUTTON_A] == GLFW_PRESS ||
                state.buttons[GLFW_GAMEPAD_BUTTON_RIGHT_BUMPER] == GLFW_PRESS,
    });
  } else if (has_gamepad_) {
    Report(GamepadEvent{});  // let go
  }
  has_gamepad_ = found;
}

Window::~Window() {
  // Xlib would wait for a lost display; the process's end frees the rest.
  if (lost()) return;
  glfwDestroyWindow(window_);
  glfwTerminate();
}

std::vector<WindowEvent> Window::WaitForEvents(double seconds) {
  if (!lost()) {
    glfwWaitEventsTimeout(seconds);
    ReportGamepad();
  }
  return std::exchange(events_, {});
}

void Window::CaptureCursor(bool on) {
  if (on == captured_ || lost()) return;
  captured_ = on;
  has_cursor_ = false;  // the cursor's jump here does not count as motion
  glfwSetInputMode(window_, GLFW_CURSOR, on ? GLFW_CURSOR_DISABLED : GLFW_CURSOR_NORMAL);
}

std::unique_ptr<RenderContext> Window::MakeContext() { return std::make_unique<Context>(this); }

}  // namespace hpdm
