#pragma once

#include <cstdlib>
#include <filesystem>

namespace hpdm {

/// Keeps sampled tissue in the build folder from here on, so that tests of one body sample it once.
inline void KeepTissue() {
  const std::filesystem::path folder = HPDM_BINARY_DIR "/tests/stress_tissue";
  std::filesystem::create_directories(folder);
  setenv("HPDM_CACHE", folder.c_str(), 1);
}

}  // namespace hpdm
