// The entry point of libFuzzer; HPDM_FUZZ_TARGET is the program's target. An exception ends the
// program, which libFuzzer reports as a crash with the input.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  hpdm::fuzz::HPDM_FUZZ_TARGET({data, size});
  return 0;
}
