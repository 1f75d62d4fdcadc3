#pragma once

#include <cstdarg>
#include <cstdio>
#include <string>

namespace hpdm {

/// Formats as printf does, up to 511 characters.
[[gnu::format(printf, 1, 2)]] inline std::string Format(const char* format, ...) {
  char text[512];
  va_list values;
  va_start(values, format);
  std::vsnprintf(text, sizeof text, format, values);
  va_end(values);
  return text;
}

}  // namespace hpdm
