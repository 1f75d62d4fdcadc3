#pragma once

#include <span>
#include <vector>

#include "engine/mesh/surface_mesh.h"
#include "render/gl/shaders.h"
#include "render/tissue/mesh_renderer.h"

namespace hpdm {

/// Returns a closed clip as a mesh in its frame (m): a bent strip of metal with two limbs along y on both
/// sides of a flattened tube that runs along z. `flat`, `wide`: the tube's half axes along x and y.
SurfaceMesh ClipMesh(double flat, double wide);

/// Draws the clips on ducts as titanium. Render thread only.
class ClipRenderer {
 public:
  /// `meshes`: ClipMesh of each duct. Throws MachineError if the driver refuses a shader.
  explicit ClipRenderer(const std::vector<SurfaceMesh>& meshes);

  /// Draws the clips of each duct at their poses.
  void Draw(std::span<const std::vector<Isometry3d>> poses_W) const;

 private:
  ShaderProgram program_;
  int world_from_mesh_, base_colour_, insulation_, insulated_from_;
  std::vector<MeshRenderer> meshes_;
};

}  // namespace hpdm
