#pragma once

#include <string>
#include <vector>

#include "tools/shared/felt_bench.h"

namespace hpdm {

inline const std::string kMeshes = std::string(HPDM_SOURCE_DIR) + "/scenes/meshes/";

inline OrganOptions SoftOrgan(const std::string& mesh, int cells) {
  OrganOptions options;
  options.name = mesh;
  options.mesh = kMeshes + mesh;
  options.energy.type = EnergyType::kStrain;
  options.lattice.cells = {cells, cells, cells};
  options.lattice.local.functions = 0;
  SupportOptions back;
  back.region = BoxFraction{Vector3d(0, 0.7, 0), Vector3d(1, 1, 1)};
  options.supports.push_back(back);
  return options;
}

inline SurfaceMesh Load(const OrganOptions& options) {
  std::vector<std::string> repairs;
  return LoadPosedMesh(options, &repairs);
}

}  // namespace hpdm
