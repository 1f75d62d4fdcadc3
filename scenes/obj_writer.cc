#include "scenes/obj_writer.h"

#include <cstdio>
#include <fstream>
#include <sstream>

#include "engine/error.h"

namespace hpdm {

std::string ObjText(const SurfaceMesh& mesh, const std::string& comment) {
  std::string text;
  std::istringstream lines(comment);
  for (std::string line; std::getline(lines, line);) text += "# " + line + "\n";
  char row[128];
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    double p[3];
    for (int k = 0; k < 3; ++k) {
      p[k] = mesh.vertices(v, k);
      // What rounds to zero is written without a sign.
      if (p[k] > -0.5e-6 && p[k] < 0.5e-6) p[k] = 0;
    }
    std::snprintf(row, sizeof row, "v %.6f %.6f %.6f\n", p[0], p[1], p[2]);
    text += row;
  }
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    std::snprintf(row, sizeof row, "f %d %d %d\n", mesh.triangles(t, 0) + 1,
                  mesh.triangles(t, 1) + 1, mesh.triangles(t, 2) + 1);
    text += row;
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
