#pragma once

#include <filesystem>
#include <string>

namespace hpdm {

/// SHA-256 of a file's bytes (FIPS 180-4), 64 lower-case hexadecimal digits, as sha256sum prints
/// it. Throws InputError where the file cannot be read. Set-up only.
std::string Sha256OfFile(const std::filesystem::path& path);

/// Whether the text has the form of such a sum.
bool IsSha256(const std::string& text);

}  // namespace hpdm
