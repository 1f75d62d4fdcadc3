#include "scenes/generator/meshing/obj_writer.h"

#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>
#include <vector>

#include "engine/base/error.h"

namespace hpdm {
namespace {

/// Appends the distinct coordinates in order of appearance. Returns the 1-based number for each
/// row.
std::vector<int> AppendTextureCoordinates(const TextureCoordinates& uv, std::string* text) {
  std::map<std::string, int> numbers;
  std::vector<int> number_of_row;
  char row[64];
  for (Eigen::Index i = 0; i < uv.rows(); ++i) {
    std::snprintf(row, sizeof row, "vt %.5f %.5f\n", uv(i, 0), uv(i, 1));
    const auto [entry, is_new] = numbers.try_emplace(row, static_cast<int>(numbers.size()) + 1);
    if (is_new) *text += row;
    number_of_row.push_back(entry->second);
  }
  return number_of_row;
}

}  // namespace

std::string ObjText(const SurfaceMesh& mesh, const std::string& comment) {
  std::string text;
  std::istringstream lines(comment);
  for (std::string line; std::getline(lines, line);) text += "# " + line + "\n";
  char row[128];
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    double p[3];
    for (int k = 0; k < 3; ++k) {
      p[k] = mesh.vertices(v, k);
      // Numbers that round to zero are written without a sign.
      if (p[k] > -0.5e-6 && p[k] < 0.5e-6) p[k] = 0;
    }
    std::snprintf(row, sizeof row, "v %.6f %.6f %.6f\n", p[0], p[1], p[2]);
    text += row;
  }
  const std::vector<int> texture = AppendTextureCoordinates(mesh.texture_coordinates, &text);
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    text += 'f';
    for (int c = 0; c < 3; ++c) {
      text += ' ' + std::to_string(mesh.triangles(t, c) + 1);
      if (!texture.empty())
        text += '/' + std::to_string(texture[static_cast<std::size_t>(3 * t + c)]);
    }
    text += '\n';
  }
  return text;
}

void WriteTextFile(const std::filesystem::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (!file) {
    throw InputError(path.string() + ": cannot be written; check the folder, its rights and space");
  }
}

}  // namespace hpdm
