#pragma once

#include <string>
#include <vector>

#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// A generated mesh, as `hpdm generate` lists it.
struct MeshAsset {
  std::string name;         ///< The file is NAME.obj.
  std::string description;  ///< One line.
  bool committed;           ///< Kept in scenes/meshes; the others are made on demand.
};

/// Returns all assets, in the order of the listing.
const std::vector<MeshAsset>& MeshAssets();

/// Generates an asset, SI, in its own frame (implicit_shapes.h for organs, instrument_mesh.h for
/// instruments). A hollow organ is its outer surface, then its cavity's, facing the cavity. The
/// same bits on every run and x86-64 machine. Throws InputError for an unknown name.
SurfaceMesh MakeMeshAsset(const std::string& name);

/// Returns the bytes of the asset's OBJ file.
std::string MeshAssetObj(const std::string& name, const SurfaceMesh& mesh);

}  // namespace hpdm
