#include "render/overlay/help_page.h"

#include "render/overlay/status_lines.h"

namespace hpdm {

std::vector<StatusLine> HelpPage(const Status& status, const StatusNames& names) {
  const auto key = [](const char* keys, const std::string& what) {
    return StatusLine{what, Tone::kPlain, {}, keys};
  };
  const int active = status.view.active_instrument;
  const int held = active < status.scene.tool_count
                       ? status.scene.tools[static_cast<std::size_t>(active)].instrument_index
                       : 0;
  const auto hand = static_cast<std::size_t>(active);
  const bool exchanges = hand < names.instruments.size() && names.instruments[hand].size() > 1;
  return {
      {"Instrument", Tone::kGood},
      key("click, Space", "hold it with the mouse; Space releases it"),
      key("mouse", "move the tip across the picture"),
      key("wheel", "up: push it in, down: pull it out; finely if turned slowly"),
      key("left button", "close the jaws while held"),
      key("j", "close the jaws and keep them closed; again: open them"),
      key("right button, q e", "roll: drag with the right button held, or hold a key"),
      key("Tab, 1 to 4", "another instrument; closed jaws stay closed (j opens them)"),
      key("x, Shift + x", "exchange it for the next, the previous one of the hand:"),
      key(" ", ExchangeOrder(names, active, held) + (exchanges ? "" : ", its only one")),
      key("d", "pedal, while held: the hook burns, suction sucks"),
      {"Second hand (the next instrument, beside that of the mouse), or a gamepad", Tone::kGood},
      key("t g f h", "move its tip up, down, left, right"),
      key("y b, c n, v", "push in and out, roll, close or open the jaws"),
      {"Laparoscope", Tone::kGood},
      key("arrows, Shift + mouse", "turn"),
      key("PgUp PgDn, Shift + wheel", "in and out"),
      key("+ \u2212, hold", "zoom"),
      key("a", "optics of 0, 30, 45\u00b0"),
      key("comma, full stop", "turn the optics about the shaft"),
      key("Home", "back to the first view"),
      {"Session", Tone::kGood},
      key("p", "pause; the exercise's time stands, and its errors are listed"),
      key("Backspace", "the exercise's step begins again; with Shift the one before"),
      key("i", "shows or hides the guidance: the steps, and what to do next"),
      key("o", "next overlay: text, forces, contacts, lattice, none"),
      key("s, r", "screenshot, record"),
      key("F1, Esc", "show or hide the keys, end the session"),
  };
}

}  // namespace hpdm
