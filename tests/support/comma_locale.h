#pragma once

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>

namespace hpdm {

/// Name of a locale that writes numbers with a decimal comma.
inline constexpr char kCommaLocale[] = "de_DE.UTF-8";

/// Builds the locale in a folder, where the C library finds it through LOCPATH. Returns false if
/// the machine cannot (Debian's package locales).
inline bool MakeCommaLocale(const std::filesystem::path& folder) {
  const std::string place = (folder / kCommaLocale).string();
  // localedef warns about faults in the system's own sources and then exits with 1.
  [[maybe_unused]] const int status =
      std::system(("localedef -i de_DE -f UTF-8 '" + place + "' >/dev/null 2>&1").c_str());
  return std::filesystem::exists(place + "/LC_NUMERIC");
}

}  // namespace hpdm
