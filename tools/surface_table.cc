#include "tools/surface_table.h"

#include <charconv>
#include <fstream>
#include <vector>

#include "engine/error.h"

namespace hpdm {
namespace {

constexpr char kHeader[] = "x,y,z,ux,uy,uz";

}  // namespace

SurfaceTable ReadSurfaceTable(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  if (!file || !std::getline(file, line) || line != kHeader) {
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
      if (error != std::errc() || (last ? next != end : next == end || *next != ',')) {
        throw InputError(path + ":" + std::to_string(number) +
                         ": is not six numbers separated by commas");
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
  std::ofstream file(path);
  file << kHeader << "\n";
  const auto number = [&](double value) {
    char text[32];
    const auto [end, error] = std::to_chars(text, text + sizeof text, value);
    file.write(text, end - text);
  };
  for (Eigen::Index v = 0; v < table.positions.rows(); ++v) {
    for (int d = 0; d < 6; ++d) {
      number(d < 3 ? table.positions(v, d) : table.displacements(v, d - 3));
      file << (d < 5 ? ',' : '\n');
    }
  }
  file.close();
  if (!file) throw InputError(path + ": cannot be written; choose another file with --out");
}

}  // namespace hpdm
