#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "engine/mesh/surface_mesh.h"
#include "engine/organ.h"
#include "engine/snapshots.h"
#include "render/camera/laparoscope.h"
#include "render/gl/shaders.h"
#include "render/gl/texture.h"
#include "render/image/colour.h"
#include "render/image/image_file.h"
#include "render/tissue/lattice_deformation.h"
#include "render/tissue/mesh_levels.h"
#include "render/tissue/mesh_renderer.h"
#include "render/tissue/occlusion.h"

namespace hpdm {

/// An organ to draw. What it points to must outlive the visual.
struct OrganVisual {
  const SurfaceMesh* rest = nullptr;  ///< Posed rest surface in the world, m: the vertices that
                                      ///< SceneSnapshot::organs[i].vertices moves.
  const Image* texture = nullptr;     ///< By the mesh's texture coordinates; null: `colour` alone.
  Colour colour = Colour(0.40f, 0.155f, 0.125f);  ///< Without a texture; liver.
  const OrganModel* model = nullptr;  ///< For a deformation on the card; null: `ffd` is kCpu.
  FfdPath ffd = FfdPath::kAuto;
  const Points* reference = nullptr;  ///< V x 3, m: displacements that kOverlayError compares with.
  double error_scale = 1e-3;          ///< m, of the overlay's last colour.
};

/// The organs on the graphics card. Render thread only.
class OrganRenderer {
 public:
  /// Compiles the program and uploads meshes, their levels (unless `levels` is false) and textures.
  /// Throws MachineError when the driver
  /// refuses the shader. A texture for a mesh without texture coordinates is a bug.
  explicit OrganRenderer(const std::vector<OrganVisual>& organs, bool levels = true);

  /// Moves the organs to where the snapshot has them, and chooses which of them are drawn in a
  /// picture through `scope`, and with which level; a shape is looked at only where its version
  /// is another than at the last call. Fewer organs or another number of vertices than at
  /// construction are a bug. Allocates nothing.
  void Move(const SceneSnapshot& snapshot, const Laparoscope& scope);

  /// Draws depth alone.
  void DrawDepth() const;

  /// Draws the organs. `occlusion` (of the same frame) may be null.
  void Draw(const Occlusion* occlusion) const;

  /// Of the organ, where the last Draw() had it.
  MeshRenderer& mesh(std::size_t organ) { return organs_[organ].mesh; }
  const MeshRenderer& mesh(std::size_t organ) const { return organs_[organ].mesh; }

 private:
  struct Organ {
    MeshRenderer mesh;
    Texture texture;
    Eigen::Vector3f colour;  // linear, multiplies the texture's
    float metres_per_uv;
    std::unique_ptr<LatticeDeformation> deformation = {};  // null: the snapshot's vertices
    std::vector<MeshLevel> levels = {};                    // the first is all of the mesh
    std::optional<std::uint64_t> version = {};             // OrganSnapshot's, of what is drawn
    Vector3d low_W = Vector3d::Zero(), high_W = Vector3d::Zero();  // m, of that shape
    bool may_be_seen = true;
    std::vector<double> errors = {};  // m, of each level in that shape; < 0: not known yet

    void SetLevels(const SurfaceMesh& rest);
    void Move(const OrganSnapshot& shape);
    void Look(const OrganSnapshot& shape, const Laparoscope& scope);
  };

  ShaderProgram program_;
  ShaderProgram depth_program_;
  int base_colour_;
  int metres_per_uv_;
  Texture detail_;
  Texture no_occlusion_;
  std::vector<Organ> organs_;
};

}  // namespace hpdm
