#pragma once

#include <filesystem>
#include <fstream>
#include <string>

namespace hpdm {

/// Changes of a test in a sound scene.
struct SceneChange {
  std::string name = "liver";
  std::string mesh = "../common/box.obj";
  std::string organ = {}, lattice = {};
  std::string cells = "cells=2\n";
  std::string energy = {}, material = {}, instrument = {};
  std::string trocar = "[0,-0.1,0.2]";
};

/// Returns a scene with a box of tissue and a probe, built in milliseconds.
inline std::string SoundScene(const SceneChange& change) {
  // A key must not be given twice.
  const std::string cells = change.lattice.starts_with("cells") ? "" : change.cells;
  return "[[organ]]\nname='" + change.name + "'\nmesh='" + change.mesh + "'\n" + change.organ +
         "[organ.lattice]\n" + cells + change.lattice + "\n[organ.energy]\n" + change.energy +
         "\n[organ.material]\n" + change.material +
         "\n[[instrument]]\nname='probe'\ntrocar=" + change.trocar + "\n" + change.instrument;
}

/// Writes box.obj: 0.1 m wide, centred at the origin, two triangles per face.
inline void WriteBox(const std::filesystem::path& folder) {
  std::ofstream file(folder / "box.obj");
  for (int i = 0; i < 8; ++i) {
    file << "v " << ((i & 1) != 0 ? 0.05 : -0.05) << ' ' << ((i & 2) != 0 ? 0.05 : -0.05) << ' '
         << ((i & 4) != 0 ? 0.05 : -0.05) << '\n';
  }
  file << "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
}

}  // namespace hpdm
