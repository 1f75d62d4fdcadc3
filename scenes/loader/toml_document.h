#pragma once

#include <toml++/toml.h>

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

/// A TOML file as the parser's nodes. Parsing toml++ costs seconds: no header includes this. Set-up
/// code: any thread, allocates.
namespace hpdm {

/// Nodes and keys have their place in the file as source(): line and column count from 1, the
/// column in characters. A table that only a longer key implies has the place of that key's part.
struct TomlDocument {
  std::filesystem::path path;  ///< As given.
  std::string text;            ///< The file's contents.
  toml::table root;
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
[[noreturn]] void FailAt(const TomlDocument& document, const toml::source_position& place,
                         std::string_view subject, std::string_view message);

/// Returns the value as TOML text for messages, cut to about 60 characters.
std::string ValueText(const toml::node& value);

}  // namespace hpdm
