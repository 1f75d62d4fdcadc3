#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

/// A TOML file as a plain tree of values with their places. Only toml_document.cc includes the
/// parser. Set-up code: any thread, allocates.
namespace hpdm {

/// A place in the file: line and column count from 1, the column in characters.
struct TomlPlace {
  std::uint32_t line = 1;
  std::uint32_t column = 1;
};

struct TomlEntry;
struct TomlValue;

/// Sorted by the keys' names, because TOML gives a table's keys no order.
using TomlTable = std::vector<TomlEntry>;
using TomlArray = std::vector<TomlValue>;
/// A date or a time of day. No key of a scene accepts one.
struct TomlDate {};

struct TomlValue {
  TomlPlace place;
  std::variant<std::int64_t, double, bool, std::string, TomlDate, TomlArray, TomlTable> value;
  /// One character past the value; equals `place` for a table that only a longer key implies.
  TomlPlace end = {};
};

struct TomlEntry {
  std::string key;
  TomlPlace place;  ///< The key's place.
  TomlValue value;
};

struct TomlDocument {
  std::filesystem::path path;  ///< As given.
  std::string text;            ///< The file's contents.
  TomlValue root;              ///< Always a TomlTable.
};

/// Larger files are refused; a scene written by a person is much smaller.
inline constexpr std::size_t kMaxTomlBytes = std::size_t{1} << 20;
/// Deeper nesting of tables and arrays is refused.
inline constexpr int kMaxTomlDepth = 32;

/// Reads and parses a file. Throws InputError (one line: file, place, remedy) if it cannot be
/// read, is larger than kMaxTomlBytes, is not TOML or is nested deeper than kMaxTomlDepth.
TomlDocument ReadToml(const std::filesystem::path& path);

/// Parses a text as ReadToml does; messages name `path`.
TomlDocument ParseToml(std::string text, const std::filesystem::path& path);

/// Throws InputError("FILE:LINE:COLUMN: subject: message"). Control characters are escaped, so the
/// message is always one line.
[[noreturn]] void FailAt(const TomlDocument& document, TomlPlace place, std::string_view subject,
                         std::string_view message);

/// Returns the value as TOML text for messages, cut to about 60 characters.
std::string ValueText(const TomlValue& value);

/// Returns the text in quotes, cut to about 60 characters.
std::string Quoted(std::string_view text);

}  // namespace hpdm
