#pragma once

#include <memory>
#include <string_view>

namespace hpdm {

/// Characters beyond ASCII that the views draw, each one column wide; ASCII ones for terminals that
/// have no others.
struct Glyphs {
  std::string_view bars[8];  ///< Of a sparkline, rising.
  std::string_view play, pause, end;
  std::string_view line, knob, ahead;  ///< Of a time line.
  std::string_view rising, falling;    ///< Order of a column.
  std::string_view closed, open;       ///< A group of fields.
  std::string_view ellipsis, separator;
};

/// What is not a character.
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

/// The terminal as a grid of characters, through ncurses (whose only user this is). From
/// construction to destruction the terminal is ours; then it is as it was. While it is, what
/// libraries print to standard error is discarded, where that is the same terminal. One at a time;
/// main thread.
class TerminalScreen {
 public:
  /// Throws MachineError where the terminal's type is not known.
  TerminalScreen();
  ~TerminalScreen();
  TerminalScreen(const TerminalScreen&) = delete;
  TerminalScreen& operator=(const TerminalScreen&) = delete;

  int rows() const;
  int columns() const;
  const Glyphs& glyphs() const { return *glyphs_; }

  void Clear();
  /// Writes UTF-8 text whose every character is one column wide; cut at the right edge. Nothing
  /// outside of the screen is written.
  void Put(int row, int column, std::string_view text, TextStyle style = TextStyle::kPlain);
  /// A whole row's background.
  void Fill(int row, TextStyle style);
  /// Brings what was written since Clear onto the terminal.
  void Show();

  /// Waits for a key; true when there is one.
  bool Wait(int milliseconds);
  /// The next key that was pressed, or kNoTerminalKey.
  int NextKey();
  /// The terminal was closed.
  bool gone() const { return gone_; }

 private:
  struct Curses;
  std::unique_ptr<Curses> curses_;
  const Glyphs* glyphs_;
  int standard_error_ = -1;  // as it was
  bool gone_ = false;
};

/// Columns of a UTF-8 text whose characters are one wide each.
int WidthOf(std::string_view text);

}  // namespace hpdm
