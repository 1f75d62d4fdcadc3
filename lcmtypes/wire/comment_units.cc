#include "lcmtypes/wire/comment_units.h"

#include <algorithm>
#include <utility>

namespace hpdm {
namespace {

std::string_view Trimmed(std::string_view text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  while (text.ends_with(' ') || text.ends_with('.')) text.remove_suffix(1);
  return text;
}

std::vector<std::string_view> Split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (std::size_t end; (end = text.find(separator)) != std::string_view::npos;) {
    parts.push_back(text.substr(0, end));
    text.remove_prefix(end + 1);
  }
  parts.push_back(text);
  return parts;
}

/// True for one symbol with or without an exponent: "m", "m^2".
bool IsSymbol(std::string_view text) {
  static constexpr std::string_view kSymbols[] = {
      "m",  "mm",  "um", "kg", "g",   "s",   "ms",  "us", "ns", "Hz", "kHz", "N", "mN",
      "Pa", "kPa", "J",  "W",  "rad", "deg", "bit", "B",  "V",  "A",  "K",   "%"};
  const std::size_t power = text.find('^');
  if (power != std::string_view::npos) {
    const std::string_view exponent = text.substr(power + 1);
    if (exponent.size() != 1 || exponent[0] < '2' || exponent[0] > '4') return false;
    text = text.substr(0, power);
  }
  return std::ranges::find(kSymbols, text) != std::end(kSymbols);
}

/// True for products and quotients of symbols: "N s/m", "1/m".
bool IsUnit(std::string_view text) {
  const std::vector<std::string_view> quotient = Split(text, '/');
  if (quotient.size() > 2) return false;
  for (std::size_t side = 0; side < quotient.size(); ++side) {
    if (side == 0 && quotient.size() == 2 && quotient[0] == "1") continue;
    for (const std::string_view symbol : Split(quotient[side], ' ')) {
      if (!IsSymbol(symbol)) return false;
    }
  }
  return true;
}

/// Returns the unit in brackets at the end of the text, or "".
std::string BracketedUnit(std::string_view text) {
  const std::size_t open = text.rfind('(');
  if (open == std::string_view::npos || !text.ends_with(')')) return "";
  const std::string_view inside = text.substr(open + 1, text.size() - open - 2);
  return IsUnit(inside) ? std::string(inside) : "";
}

}  // namespace

std::vector<std::string> CommentUnits(std::string_view comment, std::string_view member,
                                      std::int64_t count) {
  const std::vector<std::string_view> parts = Split(comment.substr(0, comment.find(';')), ',');
  const std::string_view last = Trimmed(parts.back());
  if (IsUnit(last)) return {std::string(last)};
  std::vector<std::string> units;
  for (const std::string_view part : parts) units.push_back(BracketedUnit(Trimmed(part)));
  const bool one_each = static_cast<std::int64_t>(units.size()) == count;
  const auto has_unit = [](const std::string& unit) { return !unit.empty(); };
  if (one_each && std::ranges::any_of(units, has_unit)) return units;
  static constexpr std::pair<std::string_view, std::string_view> kEndings[] = {
      {"_ns", "ns"}, {"_us", "us"}, {"_s", "s"}, {"_hz", "Hz"}};
  for (const auto& [ending, unit] : kEndings) {
    if (member.ends_with(ending)) return {std::string(unit)};
  }
  return {};
}

}  // namespace hpdm
