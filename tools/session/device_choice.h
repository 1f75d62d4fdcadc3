#pragma once

#include <string>
#include <vector>

#include "haptics/device/instrument_options.h"

namespace hpdm {

/// What moves an instrument.
struct DeviceChoice {
  enum class Type { kSim, kTrace, kLcm, kMouse };
  Type type = Type::kSim;
  std::string trace;  ///< Path; kTrace only.

  std::string Text() const;  ///< As --device takes it.
};

/// The device of each instrument. Without an answer on the command line it is the scene's trace, or
/// else the simulated hand, with a window the mouse. `arguments` are those of --device: "sim",
/// "trace:FILE", "lcm" and "mouse" for all instruments, "NAME=..." for the one of that name,
/// whatever their order. Throws InputError, also for a mouse without a window.
std::vector<DeviceChoice> ChooseDevices(const std::vector<std::string>& arguments,
                                        const std::vector<InstrumentOptions>& instruments,
                                        bool window = false);

}  // namespace hpdm
