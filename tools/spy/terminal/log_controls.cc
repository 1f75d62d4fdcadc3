#include "tools/spy/terminal/log_controls.h"

#include <algorithm>
#include <string>

#include "tools/spy/terminal/spy_text.h"

namespace hpdm {
namespace {

constexpr double kSpeeds[] = {0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, LogPlayer::kUnlimited};
constexpr std::int64_t kSecondUs = 1'000'000;

void ChangeSpeed(LogPlayer* player, bool faster) {
  if (faster) {
    const auto* next = std::upper_bound(std::begin(kSpeeds), std::end(kSpeeds), player->speed());
    if (next != std::end(kSpeeds)) player->SetSpeed(*next);
  } else {
    const auto* at = std::lower_bound(std::begin(kSpeeds), std::end(kSpeeds), player->speed());
    if (at != std::begin(kSpeeds)) player->SetSpeed(*(at - 1));
  }
}

}  // namespace

bool HandleLogKey(int key, LogPlayer* player, bool* sought) {
  const auto seek = [&](std::int64_t to_us) {
    player->Seek(to_us);
    *sought = true;
  };
  const std::int64_t position = player->position_us();
  // The length of a log with damaged time stamps may be near the limit of 64 bits.
  const auto forward = [&](std::int64_t by_us) {
    seek(player->length_us() - position > by_us ? position + by_us : player->length_us());
  };
  if (key >= '0' && key <= '9') {
    seek(player->length_us() / 10 * (key - '0'));
    return true;
  }
  switch (key) {
    case ' ':
      if (player->ended()) {
        seek(0);
        player->Pause(false);
      } else {
        player->Pause(!player->paused());
      }
      return true;
    case '+':
    case '=':
      ChangeSpeed(player, true);
      return true;
    case '-':
      ChangeSpeed(player, false);
      return true;
    case kTerminalKeyLeft:
      seek(position - 5 * kSecondUs);
      return true;
    case kTerminalKeyRight:
      forward(5 * kSecondUs);
      return true;
    case '<':
    case ',':
      seek(position - 60 * kSecondUs);
      return true;
    case '>':
    case '.':
      forward(60 * kSecondUs);
      return true;
    case kTerminalKeyHome:
      seek(0);
      return true;
    case kTerminalKeyEnd:
      seek(player->length_us());
      return true;
    default:
      return false;
  }
}

void DrawTimeLine(TerminalScreen* screen, int row, const LogPlayer& player) {
  const Glyphs& glyphs = screen->glyphs();
  std::string left(player.ended() ? glyphs.end : player.paused() ? glyphs.pause : glyphs.play);
  left += player.speed() == LogPlayer::kUnlimited ? " max " : Format(" %gx ", player.speed());
  left = FitLeft(left, 7, glyphs) + TimeText(player.position_us()) + ' ';
  const std::string right = ' ' + TimeText(player.length_us());
  screen->Put(row, 0, left, TextStyle::kBold);
  screen->Put(row, screen->columns() - WidthOf(right), right);
  const int bar = screen->columns() - WidthOf(left) - WidthOf(right);
  if (bar < 4) return;
  const double share = player.length_us() > 0 ? static_cast<double>(player.position_us()) /
                                                    static_cast<double>(player.length_us())
                                              : 0;
  const int knob = std::min(bar - 1, static_cast<int>(share * bar));
  std::string done, ahead;
  for (int i = 0; i < knob; ++i) done += glyphs.line;
  done += glyphs.knob;
  for (int i = knob + 1; i < bar; ++i) ahead += glyphs.ahead;
  screen->Put(row, WidthOf(left), done, TextStyle::kAccent);
  screen->Put(row, WidthOf(left) + knob + 1, ahead, TextStyle::kDim);
}

}  // namespace hpdm
