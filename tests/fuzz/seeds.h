#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace hpdm::fuzz {

/// An input that a reader accepts, for libFuzzer to begin with.
struct Seed {
  std::string target;  ///< A name in kTargets.
  std::string name;    ///< The file's name.
  std::vector<std::uint8_t> bytes;
};

/// The seeds in binary, which no editor writes: messages, logs, meshes. The same bytes every time.
std::vector<Seed> BinarySeeds();

}  // namespace hpdm::fuzz
