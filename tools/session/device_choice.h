#pragma once

#include <string>
#include <vector>

#include "haptics/device/instrument_options.h"

namespace hpdm {

/// The device that moves an instrument.
struct DeviceChoice {
  enum class Type {
    kSim,
    kTrace,
    kLcm,
    kMouse,
    kCommand,  ///< The program (command_device.h); not from a command line.
  };
  Type type = Type::kSim;
  std::string trace;  ///< Path; kTrace only.

  std::string Text() const;  ///< The argument of --device that selects it.
};

/// Returns the device of each instrument.
///
/// Default: the scene's trace; without one the simulated hand, or with a window the mouse.
/// `arguments` are those of --device: "sim", "trace:FILE", "lcm" or "mouse" for all instruments,
/// "NAME=..." for the instrument of that name. Their order does not matter. Throws InputError for
/// an unknown device or instrument, and for a mouse without a window.
std::vector<DeviceChoice> ChooseDevices(const std::vector<std::string>& arguments,
                                        const std::vector<InstrumentOptions>& instruments,
                                        bool window = false);

}  // namespace hpdm
