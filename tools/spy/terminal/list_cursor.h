#pragma once

#include <algorithm>

#include "tools/spy/terminal/terminal_screen.h"

namespace hpdm {

/// The selected row of a list, and the row shown at its top.
struct ListCursor {
  int selected = 0;
  int top = 0;

  /// Clamps the selected row to the list's `count` rows and scrolls it into the `height` shown
  /// rows.
  void Fit(int count, int height) {
    selected = std::clamp(selected, 0, std::max(0, count - 1));
    top = std::clamp(top, selected - std::max(1, height) + 1, selected);
    top = std::clamp(top, 0, std::max(0, count - height));
  }

  /// Returns false if the key does not move the cursor.
  bool Handle(int key, int height) {
    switch (key) {
      case kTerminalKeyUp:
      case 'k':
        --selected;
        return true;
      case kTerminalKeyDown:
      case 'j':
        ++selected;
        return true;
      case kTerminalKeyPageUp:
        selected -= std::max(1, height - 1);
        return true;
      case kTerminalKeyPageDown:
        selected += std::max(1, height - 1);
        return true;
      case 'g':
        selected = 0;
        return true;
      case 'G':
        selected = 1 << 30;
        return true;
      default:
        return false;
    }
  }
};

}  // namespace hpdm
