#pragma once

#include <cstdio>
#include <cstdlib>

/// Ends the program when a condition that only a bug can break is false. Set-up errors throw
/// (error.h); loops set flags. Kept in every build type.
#define HPDM_CHECK(condition)                                                                 \
  do {                                                                                        \
    if (!(condition)) {                                                                       \
      std::fprintf(stderr, "%s:%d: bug: check failed: %s\n", __FILE__, __LINE__, #condition); \
      std::abort();                                                                           \
    }                                                                                         \
  } while (false)
