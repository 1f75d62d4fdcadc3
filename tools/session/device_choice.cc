#include "tools/session/device_choice.h"

#include <optional>

#include "engine/base/error.h"
#include "engine/base/text_list.h"

namespace hpdm {
namespace {

constexpr std::string_view kTracePrefix = "trace:";

std::optional<DeviceChoice> Parse(const std::string& text) {
  if (text == "sim") return DeviceChoice{DeviceChoice::Type::kSim, {}};
  if (text == "lcm") return DeviceChoice{DeviceChoice::Type::kLcm, {}};
  if (text == "mouse") return DeviceChoice{DeviceChoice::Type::kMouse, {}};
  if (!text.starts_with(kTracePrefix) || text.size() == kTracePrefix.size()) return std::nullopt;
  return DeviceChoice{DeviceChoice::Type::kTrace, text.substr(kTracePrefix.size())};
}

}  // namespace

std::string DeviceChoice::Text() const {
  switch (type) {
    case Type::kSim:
      return "sim";
    case Type::kTrace:
      return std::string(kTracePrefix) + trace;
    case Type::kLcm:
      return "lcm";
    case Type::kMouse:
      return "mouse";
    case Type::kCommand:
      return "command";
  }
  return "";
}

std::vector<DeviceChoice> ChooseDevices(const std::vector<std::string>& arguments,
                                        const std::vector<InstrumentOptions>& instruments,
                                        bool window) {
  std::vector<DeviceChoice> devices;
  std::string names;
  for (const InstrumentOptions& instrument : instruments) {
    DeviceChoice& device = devices.emplace_back();
    if (!instrument.trace.file.empty()) {
      device = {DeviceChoice::Type::kTrace, instrument.trace.file};
    } else if (window) {
      device.type = DeviceChoice::Type::kMouse;
    }
    AppendToList(instrument.name, &names);
  }
  for (const std::string& argument : arguments) {
    if (const auto choice = Parse(argument)) devices.assign(instruments.size(), *choice);
  }
  for (const std::string& argument : arguments) {
    if (Parse(argument)) continue;
    const std::size_t equals = argument.find('=');
    const auto choice =
        equals == std::string::npos ? std::nullopt : Parse(argument.substr(equals + 1));
    if (!choice) {
      throw InputError("--device: unknown device \"" + argument +
                       "\"; give sim, trace:FILE, lcm or mouse, or NAME=... for one instrument");
    }
    bool found = false;
    for (std::size_t i = 0; i < instruments.size(); ++i) {
      if (instruments[i].name != argument.substr(0, equals)) continue;
      devices[i] = *choice;
      found = true;
    }
    if (!found) {
      throw InputError("--device " + argument + ": unknown instrument; the scene has " +
                       (names.empty() ? "none" : names));
    }
  }
  for (const DeviceChoice& device : devices) {
    if (device.type != DeviceChoice::Type::kMouse || window) continue;
    throw InputError("--device mouse needs a window; add --window");
  }
  return devices;
}

}  // namespace hpdm
