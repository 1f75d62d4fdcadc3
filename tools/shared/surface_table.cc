#include "tools/shared/surface_table.h"

#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "tools/shared/staged_file.h"

namespace hpdm {
namespace {

constexpr char kHeader[] = "x,y,z,ux,uy,uz";

}  // namespace

SurfaceTable ReadSurfaceTable(const std::string& path) {
  std::ifstream file;
  std::error_code ignored;
  if (std::filesystem::is_regular_file(path, ignored)) file.open(path);
  if (!file.is_open()) {
    throw InputError(path + ": cannot be read; give a table that hpdm solve --out wrote");
  }
  std::string line;
  if (!std::getline(file, line) || line != kHeader) {
    throw InputError(path + ":1: is not a surface table; its first line must be " + kHeader);
  }
  std::vector<double> values;
  for (int number = 2; std::getline(file, line); ++number) {
    const char* at = line.data();
    const char* end = at + line.size();
    for (int column = 0; column < 6; ++column) {
      double value = 0;
      const auto [next, error] = std::from_chars(at, end, value);
      const bool last = column == 5;
      if (error != std::errc() || !std::isfinite(value) ||
          (last ? next != end : next == end || *next != ',')) {
        throw InputError(path + ":" + std::to_string(number) +
                         ": is not six finite numbers separated by commas; write it again with "
                         "hpdm solve --out");
      }
      values.push_back(value);
      at = next + !last;
    }
  }
  const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>> rows(
      values.data(), static_cast<Eigen::Index>(values.size() / 6), 6);
  return {rows.leftCols<3>(), rows.rightCols<3>()};
}

void WriteSurfaceTable(const std::string& path, const SurfaceTable& table) {
  StagedFile file(path);
  std::string text = std::string(kHeader) + "\n";
  for (Eigen::Index v = 0; v < table.positions.rows(); ++v) {
    for (int d = 0; d < 6; ++d) {
      const double value = d < 3 ? table.positions(v, d) : table.displacements(v, d - 3);
      char digits[32];
      text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
      text += d < 5 ? ',' : '\n';
    }
  }
  file.Write(text);
  file.Commit();
}

}  // namespace hpdm
