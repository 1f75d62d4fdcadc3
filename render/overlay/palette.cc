#include "render/overlay/palette.h"

namespace hpdm {

TextColour ColourOf(Tone tone, Palette palette) {
  const bool safe = palette == Palette::kColourBlind;
  switch (tone) {
    case Tone::kPlain:
      return {0.92f, 0.93f, 0.94f, 1};
    case Tone::kDim:
      return {0.60f, 0.63f, 0.66f, 1};
    case Tone::kGood:
      return safe ? TextColour(86 / 255.f, 180 / 255.f, 233 / 255.f, 1)
                  : TextColour(0.45f, 0.85f, 0.95f, 1);
    case Tone::kWarning:
      return safe ? TextColour(240 / 255.f, 228 / 255.f, 66 / 255.f, 1)
                  : TextColour(1.0f, 0.80f, 0.30f, 1);
    case Tone::kAlarm:
      return safe ? TextColour(213 / 255.f, 94 / 255.f, 0, 1) : TextColour(1.0f, 0.42f, 0.36f, 1);
  }
  return TextColour::Ones();
}

TextColour BarColour(double fraction, Palette palette) {
  const double limits = kBarLimits * fraction;
  if (limits > 1) return ColourOf(Tone::kAlarm, palette);
  if (limits >= 2. / 3) return ColourOf(Tone::kWarning, palette);
  return palette == Palette::kColourBlind ? ColourOf(Tone::kGood, palette)
                                          : TextColour(0.35f, 0.80f, 0.45f, 1);
}

}  // namespace hpdm
