#include "tools/spy/terminal/terminal_screen.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <clocale>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "engine/base/error.h"

#define NCURSES_NOMACROS
#define NCURSES_WIDECHAR 1
#include <curses.h>

namespace hpdm {
namespace {

constexpr Glyphs kUnicode = {{"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"},
                             "▶",
                             "‖",
                             "■",
                             "━",
                             "●",
                             "─",
                             "▲",
                             "▼",
                             "▸",
                             "▾",
                             "…",
                             "│"};
constexpr Glyphs kAscii = {{"_", ".", "-", "~", "=", "+", "*", "#"},
                           ">",
                           "|",
                           "#",
                           "=",
                           "O",
                           "-",
                           "^",
                           "v",
                           "+",
                           "-",
                           "~",
                           "|"};

/// False for terminal types that draw few characters beyond ASCII.
bool HasUnicode() {
  const char* type = std::getenv("TERM");
  const std::string name = type != nullptr ? type : "";
  return name != "linux" && name != "ansi" && name != "dumb" && !name.starts_with("vt");
}

bool SameFile(int a, int b) {
  struct stat x, y;
  return fstat(a, &x) == 0 && fstat(b, &y) == 0 && x.st_dev == y.st_dev && x.st_ino == y.st_ino;
}

/// Returns the number of bytes of the first `columns` characters.
std::size_t BytesOf(std::string_view text, int columns) {
  std::size_t bytes = 0;
  for (; bytes < text.size(); ++bytes) {
    const bool starts = (static_cast<unsigned char>(text[bytes]) & 0xC0) != 0x80;
    if (starts && columns-- == 0) break;
  }
  return bytes;
}

enum Pair : short { kAlarmPair = 1, kAccentPair };

}  // namespace

int WidthOf(std::string_view text) {
  return static_cast<int>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0) != 0x80;
  }));
}

struct TerminalScreen::Curses {
  SCREEN* screen = nullptr;
  bool colours = false;

  attr_t Attributes(TextStyle style) const {
    switch (style) {
      case TextStyle::kPlain:
        return A_NORMAL;
      case TextStyle::kBold:
        return A_BOLD;
      case TextStyle::kDim:
        return A_DIM;
      case TextStyle::kBar:
      case TextStyle::kSelected:
        return A_REVERSE;
      case TextStyle::kAlarm:
        return A_BOLD | (colours ? COLOR_PAIR(kAlarmPair) : A_UNDERLINE);
      case TextStyle::kAccent:
        return colours ? COLOR_PAIR(kAccentPair) : A_NORMAL;
    }
    return A_NORMAL;
  }
};

TerminalScreen::TerminalScreen()
    : curses_(std::make_unique<Curses>()), glyphs_(HasUnicode() ? &kUnicode : &kAscii) {
  // LC_CTYPE only, so that numbers keep their decimal points.
  if (std::setlocale(LC_CTYPE, "C.UTF-8") == nullptr) glyphs_ = &kAscii;
  curses_->screen = newterm(nullptr, stdout, stdin);
  if (curses_->screen == nullptr) {
    const char* type = std::getenv("TERM");
    throw MachineError("spy: the terminal's type TERM=" + std::string(type != nullptr ? type : "") +
                       " is unknown; set TERM=xterm, or give --once");
  }
  set_escdelay(25);
  cbreak();
  noecho();
  nonl();
  keypad(stdscr, TRUE);
  nodelay(stdscr, TRUE);
  curs_set(0);
  const char* no_color = std::getenv("NO_COLOR");
  if (has_colors() && (no_color == nullptr || *no_color == '\0')) {
    start_color();
    use_default_colors();
    init_pair(kAlarmPair, COLOR_RED, -1);
    init_pair(kAccentPair, COLOR_CYAN, -1);
    curses_->colours = true;
  }
  if (isatty(STDERR_FILENO) != 0 && SameFile(STDERR_FILENO, STDOUT_FILENO)) {
    std::fflush(stderr);
    standard_error_ = fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3);
    const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
    if (nowhere >= 0) {
      dup2(nowhere, STDERR_FILENO);
      close(nowhere);
    }
  }
}

TerminalScreen::~TerminalScreen() {
  if (standard_error_ >= 0) {
    dup2(standard_error_, STDERR_FILENO);
    close(standard_error_);
  }
  endwin();
  delscreen(curses_->screen);
}

int TerminalScreen::rows() const { return getmaxy(stdscr); }
int TerminalScreen::columns() const { return getmaxx(stdscr); }

void TerminalScreen::Clear() { werase(stdscr); }

void TerminalScreen::Put(int row, int column, std::string_view text, TextStyle style) {
  const int room = columns() - column;
  if (row < 0 || row >= rows() || column < 0 || room <= 0) return;
  wattrset(stdscr, static_cast<int>(curses_->Attributes(style)));
  mvwaddnstr(stdscr, row, column, text.data(), static_cast<int>(BytesOf(text, room)));
}

void TerminalScreen::Fill(int row, TextStyle style) {
  Put(row, 0, std::string(static_cast<std::size_t>(std::max(0, columns())), ' '), style);
}

void TerminalScreen::Show() { wrefresh(stdscr); }

bool TerminalScreen::Wait(int milliseconds) {
  pollfd input = {STDIN_FILENO, POLLIN, 0};
  const int ready = poll(&input, 1, milliseconds);
  if (ready > 0 && (input.revents & (POLLHUP | POLLERR | POLLNVAL)) != 0) gone_ = true;
  return ready != 0;  // -1: a signal, which may be a change of size
}

int TerminalScreen::NextKey() {
  const int key = wgetch(stdscr);
  switch (key) {
    case ERR:
      return kNoTerminalKey;
    case KEY_UP:
      return kTerminalKeyUp;
    case KEY_DOWN:
      return kTerminalKeyDown;
    case KEY_LEFT:
      return kTerminalKeyLeft;
    case KEY_RIGHT:
      return kTerminalKeyRight;
    case KEY_PPAGE:
      return kTerminalKeyPageUp;
    case KEY_NPAGE:
      return kTerminalKeyPageDown;
    case KEY_HOME:
      return kTerminalKeyHome;
    case KEY_END:
      return kTerminalKeyEnd;
    case KEY_ENTER:
    case '\r':
    case '\n':
      return kTerminalKeyEnter;
    case KEY_BACKSPACE:
    case 0x7f:
    case '\b':
      return kTerminalKeyBackspace;
    case 0x1b:
      return kTerminalKeyEscape;
    case KEY_RESIZE:
      // Terminals may change their rows when they are resized, so everything is redrawn.
      clearok(stdscr, TRUE);
      return kTerminalKeyResize;
    default:
      return key;
  }
}

}  // namespace hpdm
