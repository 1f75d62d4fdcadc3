#pragma once

#include <cstdio>
#include <cstdlib>

/// Aborts the program if `condition` is false, which only a bug can cause. Set-up errors throw
/// instead (error.h), and loops set flags. The check stays in every build type.
#define HPDM_CHECK(condition)                                                                 \
  do {                                                                                        \
    if (!(condition)) {                                                                       \
      std::fprintf(stderr, "%s:%d: bug: check failed: %s\n", __FILE__, __LINE__, #condition); \
      std::abort();                                                                           \
    }                                                                                         \
  } while (false)
