#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "tests/support/mesh_shapes.h"

/// Files that are given for meshes and are faulty, or sound in an unusual way.
namespace hpdm {

struct MeshFault {
  std::string file;  ///< Name with its ending; a row of tests/bad_input/meshes.csv.
  std::function<void(const std::filesystem::path&)> make;  ///< Puts it at a path of that name.
};

/// Collects faults. Which vertex, triangle or byte a fault strikes is drawn from a seed: those that
/// the table's words depend on (a line, a count) change with it.
class MeshFaults {
 public:
  explicit MeshFaults(std::uint32_t seed) : random_(seed) {}

  void Add(std::string file, std::string bytes);
  /// Something other than a file with bytes.
  void Add(std::string file, std::function<void(const std::filesystem::path&)> make) {
    all_.push_back({std::move(file), std::move(make)});
  }
  /// A mesh in the file's own format: STL and PLY in binary.
  void Add(const std::string& file, const SurfaceMesh& mesh);

  /// One of 0 .. count - 1. (The standard's distributions differ between libraries.)
  std::size_t Draw(std::size_t count) { return random_() % count; }
  /// In the cube [-1, 1]^3.
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

/// A text with the first `from` in it replaced.
inline std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

/// The sound body that the faults are made of: a sphere, radius 50 mm, 42 vertices, 80 triangles.
inline SurfaceMesh SoundBody() { return MakeSphere(1, 0.05); }

void AddShapeFaults(MeshFaults* faults);  ///< Of the surface, whatever the format.
void AddObjFaults(MeshFaults* faults);    ///< Of the formats.
void AddPlyFaults(MeshFaults* faults);
void AddStlFaults(MeshFaults* faults);
void AddFileFaults(MeshFaults* faults);  ///< No file, no mesh file, far too much of one.

inline void AddEveryFault(MeshFaults* faults) {
  AddShapeFaults(faults);
  AddObjFaults(faults);
  AddPlyFaults(faults);
  AddStlFaults(faults);
  AddFileFaults(faults);
}

}  // namespace hpdm
