#pragma once

#include <CLI/CLI.hpp>
#include <charconv>
#include <string>
#include <string_view>

namespace hpdm {

/// The number that the whole text is, whatever the locale; false where it is none.
template <typename Number>
bool ReadNumber(std::string_view text, Number* number) {
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), *number);
  return error == std::errc() && end == text.data() + text.size();
}

/// A check of an option that takes a number from `min` to `max`. CLI11's own Range takes NaN.
inline CLI::Validator NumberFrom(double min, double max) {
  const auto text = [](double number) {
    char digits[32];
    return std::string(digits, std::to_chars(digits, digits + sizeof digits, number).ptr);
  };
  const std::string range = text(min) + " to " + text(max);
  return {[=](std::string& given) {
            double number = 0;
            const bool fits = ReadNumber(given, &number) && number >= min && number <= max;
            return fits ? std::string() : given + " is no number from " + range;
          },
          "in " + range};
}

}  // namespace hpdm
