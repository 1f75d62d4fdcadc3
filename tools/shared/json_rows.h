#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace hpdm {

/// A flat JSON object as lines of CSV, each with its end: its keys, and its values (null: empty).
std::string CsvNames(const nlohmann::ordered_json& row);
std::string CsvValues(const nlohmann::ordered_json& row);

}  // namespace hpdm
