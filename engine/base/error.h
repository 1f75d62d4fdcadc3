#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace hpdm {

/// A message as one line of a terminal: what is in it of a file, a name or an argument can neither
/// break the line nor move the cursor. Control characters and bytes that are no UTF-8 become \n or
/// \xNN; of what is longer than 2,000 bytes the middle is left out, so that place and remedy stay.
std::string OneLine(std::string_view text);

/// Bad input found during set-up: the message is one line (OneLine) that names the file, the place
/// in it and the remedy. Commands print it and exit with 2.
class InputError : public std::runtime_error {
 public:
  explicit InputError(std::string_view message) : std::runtime_error(OneLine(message)) {}
};

/// The machine lacks something that was asked for (real-time rights, a display): one line (OneLine)
/// with the remedy. Commands print it and exit with 3.
class MachineError : public std::runtime_error {
 public:
  explicit MachineError(std::string_view message) : std::runtime_error(OneLine(message)) {}
};

}  // namespace hpdm
