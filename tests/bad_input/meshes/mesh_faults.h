#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "tests/support/mesh_shapes.h"

/// Mesh files that are faulty, or sound in an unusual way.
namespace hpdm {

struct MeshFault {
  std::string file;  ///< Name with its ending; a row of tests/bad_input/meshes.csv.
  std::function<void(const std::filesystem::path&)> make;  ///< Writes it to a path of that name.
};

/// Collects faults. A seed selects the vertex, triangle or byte of each fault. The table's messages
/// with a line or a count depend on it.
class MeshFaults {
 public:
  explicit MeshFaults(std::uint32_t seed) : random_(seed) {}

  void Add(std::string file, std::string bytes);
  /// Adds anything other than a file with bytes.
  void Add(std::string file, std::function<void(const std::filesystem::path&)> make) {
    all_.push_back({std::move(file), std::move(make)});
  }
  /// Adds a mesh in the file's format: STL and PLY in binary.
  void Add(const std::string& file, const SurfaceMesh& mesh);

  /// Returns one of 0 .. count - 1. (The standard's distributions differ between libraries.)
  std::size_t Draw(std::size_t count) { return random_() % count; }
  /// Returns a point in the cube [-1, 1]^3.
  Vector3d DrawPoint() {
    Vector3d p;
    for (double& x : p) x = random_() / 2147483648.0 - 1;
    return p;
  }

  const std::vector<MeshFault>& all() const { return all_; }

 private:
  std::mt19937 random_;
  std::vector<MeshFault> all_;
};

/// Returns a text with the first `from` replaced.
inline std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

/// Returns the sound body of the faults: a sphere, radius 50 mm, 42 vertices, 80 triangles.
inline SurfaceMesh SoundBody() { return MakeSphere(1, 0.05); }

void AddShapeFaults(MeshFaults* faults);  ///< Faults of the surface, independent of the format.
void AddObjFaults(MeshFaults* faults);    ///< Faults of the formats, also below.
void AddPlyFaults(MeshFaults* faults);
void AddStlFaults(MeshFaults* faults);
void AddFileFaults(MeshFaults* faults);  ///< Missing, wrong and oversized files.

inline void AddEveryFault(MeshFaults* faults) {
  AddShapeFaults(faults);
  AddObjFaults(faults);
  AddPlyFaults(faults);
  AddStlFaults(faults);
  AddFileFaults(faults);
}

}  // namespace hpdm
