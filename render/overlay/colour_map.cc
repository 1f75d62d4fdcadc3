#include "render/overlay/colour_map.h"

#include <algorithm>
#include <array>
#include <cstdio>

namespace hpdm {
namespace {

constexpr int kColours = 17;
constexpr std::array<std::array<float, 3>, kColours> kViridis = {{{0.2670f, 0.0049f, 0.3294f},
                                                                  {0.2823f, 0.0950f, 0.4173f},
                                                                  {0.2788f, 0.1755f, 0.4834f},
                                                                  {0.2590f, 0.2515f, 0.5247f},
                                                                  {0.2297f, 0.3224f, 0.5457f},
                                                                  {0.1994f, 0.3876f, 0.5546f},
                                                                  {0.1727f, 0.4488f, 0.5579f},
                                                                  {0.1490f, 0.5081f, 0.5572f},
                                                                  {0.1276f, 0.5669f, 0.5506f},
                                                                  {0.1201f, 0.6222f, 0.5349f},
                                                                  {0.1539f, 0.6802f, 0.5042f},
                                                                  {0.2394f, 0.7356f, 0.4557f},
                                                                  {0.3607f, 0.7860f, 0.3878f},
                                                                  {0.5063f, 0.8288f, 0.3004f},
                                                                  {0.6681f, 0.8620f, 0.1963f},
                                                                  {0.8353f, 0.8860f, 0.1026f},
                                                                  {0.9932f, 0.9062f, 0.1439f}}};

Colour At(int i) { return {kViridis[i][0], kViridis[i][1], kViridis[i][2]}; }

}  // namespace

Colour MapColour(double value) {
  const double at = std::clamp(value, 0.0, 1.0) * (kColours - 1);
  const int i = std::min(static_cast<int>(at), kColours - 2);
  return At(i) + static_cast<float>(at - i) * (At(i + 1) - At(i));
}

std::string ColourMapGlsl() {
  std::string text = "const vec3 kColours[" + std::to_string(kColours) + "] = vec3[](\n";
  for (int i = 0; i < kColours; ++i) {
    char line[80];
    std::snprintf(line, sizeof line, "  vec3(%.4f, %.4f, %.4f)%s\n",
                  static_cast<double>(kViridis[i][0]), static_cast<double>(kViridis[i][1]),
                  static_cast<double>(kViridis[i][2]), i + 1 < kColours ? "," : ");");
    text += line;
  }
  const std::string last = std::to_string(kColours - 1);
  return text + "vec3 MapColour(float value) {\n  float at = clamp(value, 0.0, 1.0) * " + last +
         ".0;\n  int i = min(int(at), " + last +
         " - 1);\n  return mix(kColours[i], kColours[i + 1], at - float(i));\n}\n";
}

}  // namespace hpdm
