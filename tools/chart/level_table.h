#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "tools/shared/static_case.h"

namespace hpdm {

struct LevelCase {
  StaticCase load_case;
  CaseReference reference;
};

/// Measures uniform lattices and lattices with adaptive functions on each case, without local
/// functions, and writes levels.md into `folder`: the error of each, and how many functions a
/// uniform lattice needs for the error of an adaptive one. `quick`: fewer lattices. Calls say(line)
/// after each.
void MeasureLevels(const std::vector<LevelCase>& cases, const std::filesystem::path& folder,
                   bool quick, const std::function<void(const std::string&)>& say);

/// Returns how many functions uniform lattices need for `error`: on the line through the two
/// neighbouring points of `uniform` (functions, error; ascending functions) in logarithms; 0 if no
/// point has so small an error.
double UniformFunctions(const std::vector<std::pair<double, double>>& uniform, double error);

}  // namespace hpdm
