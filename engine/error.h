#pragma once

#include <stdexcept>
#include <string>

namespace hpdm {

/// Bad input found during set-up: the message is one line that names the file, the place in it
/// and the remedy. Commands print it and exit with 2.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The machine lacks something that was asked for (real-time rights, a display): one line with the
/// remedy. Commands print it and exit with 3.
class MachineError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace hpdm
