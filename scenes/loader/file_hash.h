#pragma once

#include <filesystem>
#include <string>

namespace hpdm {

/// SHA-256 of a file's bytes (FIPS 180-4) as 64 lower-case hexadecimal digits, like sha256sum.
/// Throws InputError if the file cannot be read. Set-up only.
std::string Sha256OfFile(const std::filesystem::path& path);

/// True if the text consists of 64 lower-case hexadecimal digits.
bool IsSha256(const std::string& text);

}  // namespace hpdm
