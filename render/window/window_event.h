#pragma once

#include <variant>

namespace hpdm {

/// A key by its label: the ASCII code of its character without shift (letters in lower case), or
/// one of these. In a layout without ASCII letters, a key counts as that of a US keyboard.
enum Key : int {
  kKeyOther = 0x100,
  kKeyEscape,
  kKeyTab,
  kKeyF1,
  kKeyShift,
  kKeyLeft,
  kKeyRight,
  kKeyUp,
  kKeyDown,
  kKeyPageUp,
  kKeyPageDown,
  kKeyHome,
  kKeyBackspace,
};

enum class MouseButton { kLeft, kRight, kMiddle };

/// A window's events, as plain values without types of a window library.
struct KeyEvent {
  int key = kKeyOther;  ///< Key, or an ASCII code.
  bool down = false;    ///< Pressed or released; a held key is reported once.
};
struct MotionEvent {
  double dx = 0;  ///< px of the picture, to the right.
  double dy = 0;  ///< px, downwards.
};
struct WheelEvent {
  double steps = 0;  ///< Away from the user.
};
struct ButtonEvent {
  MouseButton button = MouseButton::kLeft;
  bool down = false;
};
struct ResizeEvent {
  int width = 0;   ///< px of the window's framebuffer; 0 when minimised.
  int height = 0;  ///< px.
};
struct FocusEvent {
  bool focused = false;
};
/// The state of the first gamepad; reported at every wait while one is connected.
struct GamepadEvent {
  double right = 0, up = 0;  ///< Left stick, -1 .. 1.
  double in = 0;             ///< Right trigger minus left trigger, -1 .. 1.
  double roll = 0;           ///< Right stick, to the right, -1 .. 1.
  bool grip = false;         ///< The lower button or the right bumper is held.
};
struct CloseEvent {};  ///< The user closes the window.

using WindowEvent = std::variant<KeyEvent, MotionEvent, WheelEvent, ButtonEvent, ResizeEvent,
                                 FocusEvent, GamepadEvent, CloseEvent>;

}  // namespace hpdm
