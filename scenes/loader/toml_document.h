#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

/// A TOML file as a plain tree of values with their places; the parser behind it shows nowhere
/// else. Set-up code: any thread, allocates.
namespace hpdm {

/// Where something stands in the file: line and column count from 1, the column in characters.
struct TomlPlace {
  std::uint32_t line = 1;
  std::uint32_t column = 1;
};

struct TomlEntry;
struct TomlValue;

/// In the order of the keys' names: TOML gives a table's keys no order.
using TomlTable = std::vector<TomlEntry>;
using TomlArray = std::vector<TomlValue>;
/// A date or a time of day, which no key of a scene takes.
struct TomlDate {};

struct TomlValue {
  TomlPlace place;
  std::variant<std::int64_t, double, bool, std::string, TomlDate, TomlArray, TomlTable> value;
  /// One character past it; as `place` for a table that only a longer key implies.
  TomlPlace end = {};
};

struct TomlEntry {
  std::string key;
  TomlPlace place;  ///< Of the key.
  TomlValue value;
};

struct TomlDocument {
  std::filesystem::path path;  ///< As given.
  std::string text;            ///< As read.
  TomlValue root;              ///< Always a TomlTable.
};

/// Larger files are refused unread: no scene written by a person comes near.
inline constexpr std::size_t kMaxTomlBytes = std::size_t{1} << 20;
/// Tables and arrays inside each other beyond this depth are refused.
inline constexpr int kMaxTomlDepth = 32;

/// Reads and parses a file. Throws InputError (one line: file, place, remedy) when it cannot be
/// read, is larger than kMaxTomlBytes, is not TOML or is nested deeper than kMaxTomlDepth.
TomlDocument ReadToml(const std::filesystem::path& path);

/// The same for a text; `path` stands in the messages.
TomlDocument ParseToml(std::string text, const std::filesystem::path& path);

/// Throws InputError("FILE:LINE:COLUMN: subject: message"), control characters escaped so that it
/// is one line whatever the file holds.
[[noreturn]] void FailAt(const TomlDocument& document, TomlPlace place, std::string_view subject,
                         std::string_view message);

/// The value as one would write it, cut to about 60 characters, for messages.
std::string ValueText(const TomlValue& value);

/// The same for a string: quoted.
std::string Quoted(std::string_view text);

}  // namespace hpdm
