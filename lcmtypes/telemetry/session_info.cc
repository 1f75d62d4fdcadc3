#include "lcmtypes/telemetry/session_info.h"

#include "engine/base/text_list.h"

namespace hpdm {
namespace {

constexpr std::string_view kPrefix = "instruments: ";
constexpr std::string_view kSeparator = ", ";

}  // namespace

std::string SessionStartText(const std::vector<std::string>& instruments) {
  std::string names;
  for (const std::string& name : instruments) AppendToList(name, &names, kSeparator);
  return std::string(kPrefix) + names;
}

std::vector<std::string> InstrumentsIn(std::string_view start_text, std::size_t max) {
  std::vector<std::string> names;
  if (!start_text.starts_with(kPrefix)) return names;
  std::string_view rest = start_text.substr(kPrefix.size());
  while (!rest.empty() && names.size() < max) {
    const std::size_t end = names.size() + 1 < max ? rest.find(kSeparator) : rest.npos;
    names.emplace_back(rest.substr(0, end));
    rest = end == rest.npos ? "" : rest.substr(end + kSeparator.size());
  }
  return names;
}

}  // namespace hpdm
