#pragma once

#include <memory>
#include <string_view>

namespace hpdm {

/// Special characters of the views, each one column wide. Terminals without Unicode get ASCII ones.
struct Glyphs {
  std::string_view bars[8];  ///< For sparklines, rising.
  std::string_view play, pause, end;
  std::string_view line, knob, ahead;  ///< For the time line.
  std::string_view rising, falling;    ///< For the order of a column.
  std::string_view closed, open;       ///< For a group of fields.
  std::string_view ellipsis, separator;
};

/// Keys that are not characters.
enum TerminalKey : int {
  kNoTerminalKey = -1,
  kTerminalKeyUp = 0x200000,  // beyond Unicode
  kTerminalKeyDown,
  kTerminalKeyLeft,
  kTerminalKeyRight,
  kTerminalKeyPageUp,
  kTerminalKeyPageDown,
  kTerminalKeyHome,
  kTerminalKeyEnd,
  kTerminalKeyEnter,
  kTerminalKeyBackspace,
  kTerminalKeyEscape,
  kTerminalKeyResize,
};

enum class TextStyle { kPlain, kBold, kDim, kBar, kSelected, kAlarm, kAccent };

/// The terminal as a grid of characters, drawn with ncurses, which only this class uses. The
/// destructor restores the terminal. Meanwhile standard error is discarded if it is the same
/// terminal. At most one object at a time; main thread.
class TerminalScreen {
 public:
  /// Throws MachineError if the terminal's type is unknown.
  TerminalScreen();
  ~TerminalScreen();
  TerminalScreen(const TerminalScreen&) = delete;
  TerminalScreen& operator=(const TerminalScreen&) = delete;

  int rows() const;
  int columns() const;
  const Glyphs& glyphs() const { return *glyphs_; }

  void Clear();
  /// Writes UTF-8 text whose characters are one column wide each. Text outside the screen is cut.
  void Put(int row, int column, std::string_view text, TextStyle style = TextStyle::kPlain);
  /// Sets a whole row's background.
  void Fill(int row, TextStyle style);
  /// Shows the text written since Clear on the terminal.
  void Show();

  /// Waits for a key; true if there is one.
  bool Wait(int milliseconds);
  /// Returns the next key that was pressed, or kNoTerminalKey.
  int NextKey();
  /// True if the terminal was closed.
  bool gone() const { return gone_; }

 private:
  struct Curses;
  std::unique_ptr<Curses> curses_;
  const Glyphs* glyphs_;
  int standard_error_ = -1;  // the original one
  bool gone_ = false;
};

/// Returns the number of columns of a UTF-8 text whose characters are one column wide each.
int WidthOf(std::string_view text);

}  // namespace hpdm
