#include "tools/shared/json_rows.h"

namespace hpdm {
namespace {

// Quotes a text with a comma, a quotation mark or a line end (RFC 4180), such as a file name.
std::string Quoted(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

}  // namespace

std::string CsvNames(const nlohmann::ordered_json& row) {
  std::string line;
  for (const auto& [name, value] : row.items()) line += (line.empty() ? "" : ",") + name;
  return line + "\n";
}

std::string CsvValues(const nlohmann::ordered_json& row) {
  std::string line;
  bool first = true;
  for (const auto& [name, value] : row.items()) {
    if (!first) line += ",";
    first = false;
    if (value.is_string()) {
      line += Quoted(value.get<std::string>());
    } else if (!value.is_null()) {
      line += value.dump();
    }
  }
  return line + "\n";
}

}  // namespace hpdm
