#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace hpdm {

/// Returns `text` as one line of a terminal. Escapes control characters and invalid UTF-8 as \n or
/// \xNN, so untrusted text can neither break the line nor move the cursor. Cuts the middle out of
/// lines longer than 2,000 bytes, so the place in front and the remedy at the end stay.
std::string OneLine(std::string_view text);

/// Names a key of a scene: `key` ("support[0]", "hand.target") in the `table` ("organ",
/// "instrument") of that name.
struct OptionKey {
  std::string table, name, key;
};

/// Bad input found during set-up. The message is one line (OneLine) that names the file, the place
/// in it and the remedy. Commands print it and exit with 2.
class InputError : public std::runtime_error {
 public:
  explicit InputError(std::string_view message) : std::runtime_error(OneLine(message)) {}
  /// For a thrower that does not know the scene's file: `key` is at fault.
  InputError(std::string_view message, OptionKey key)
      : std::runtime_error(OneLine(message)), key_(std::move(key)) {}

  /// Returns the scene's key at fault, without a table if none is known.
  const OptionKey& key() const { return key_; }

 private:
  OptionKey key_;
};

/// The machine lacks something that the user asked for, such as real-time rights or a display. The
/// message is one line (OneLine) with the remedy. Commands print it and exit with 3.
class MachineError : public std::runtime_error {
 public:
  explicit MachineError(std::string_view message) : std::runtime_error(OneLine(message)) {}
};

}  // namespace hpdm
