#include "tools/python/native/session_arguments.h"

#include "engine/base/error.h"
#include "render/camera/laparoscope.h"
#include "scenes/loader/scene.h"
#include "tools/python/native/python_errors.h"

namespace hpdm {

CommandKind KindOf(const std::string& text) {
  if (text == "axes") return CommandKind::kAxes;
  if (text == "tip") return CommandKind::kTip;
  FailValue("command: \"" + text + "\" is not known; give \"axes\" or \"tip\"");
}

std::vector<DeviceChoice> DevicesOf(const std::vector<std::string>& arguments, const Scene& scene) {
  std::vector<DeviceChoice> devices(scene.instruments.size(), {DeviceChoice::Type::kCommand, {}});
  std::vector<std::string> others;
  for (const std::string& argument : arguments) {
    if (argument != "command") others.push_back(argument);
  }
  if (others.empty()) return devices;
  const std::vector<DeviceChoice> chosen = ChooseDevices(others, scene.instruments);
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    if (chosen[i].type == DeviceChoice::Type::kLcm) {
      throw InputError("device \"lcm\" needs the real clock; start `hpdm run --device lcm`");
    }
    const std::string prefix = scene.instruments[i].name + "=";
    bool named = false;
    for (const std::string& other : others) {
      named = named || other.starts_with(prefix) ||
              (other.find('=') == std::string::npos || other.starts_with("trace:"));
    }
    if (named) devices[i] = chosen[i];
  }
  return devices;
}

PictureWish WishOf(int width, int height, bool depth, bool organs) {
  constexpr int kLeast = Laparoscope::kMinSide, kMost = Laparoscope::kMaxSide;
  if (width < kLeast || width > kMost || height < kLeast || height > kMost) {
    FailValue("a picture has " + std::to_string(kLeast) + " to " + std::to_string(kMost) +
              " pixels on each side, not " + std::to_string(width) + " x " +
              std::to_string(height));
  }
  return {width, height, depth, organs};
}

}  // namespace hpdm
