#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace hpdm {

/// Returns the keys or the values of a flat JSON object as one line of CSV with its line end. Null
/// becomes an empty cell.
std::string CsvNames(const nlohmann::ordered_json& row);
std::string CsvValues(const nlohmann::ordered_json& row);

}  // namespace hpdm
