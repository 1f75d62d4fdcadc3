#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "engine/mesh/surface_mesh.h"
#include "engine/organ.h"
#include "engine/scene_limits.h"
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

/// An organ to draw. The objects that it points to must outlive the visual.
struct OrganVisual {
  const SurfaceMesh* rest = nullptr;  ///< Posed rest surface in the world, m; the snapshot's
                                      ///< vertices are its deformed vertices.
  const Image* texture = nullptr;     ///< By the mesh's texture coordinates; null: `colour` alone.
  Colour colour = Colour(0.40f, 0.155f, 0.125f);  ///< Liver; used without a texture.
  const OrganModel* model = nullptr;  ///< For a deformation on the card; null: `ffd` is kCpu.
  FfdPath ffd = FfdPath::kAuto;
  const Points* reference = nullptr;  ///< V x 3, m: reference displacements of kOverlayError.
  double error_scale = 1e-3;          ///< Error with the overlay's last colour, m.
};

/// How the instruments shade the tissue.
struct ToolShade {
  int tools = kMaxInstruments;  ///< Number of instruments in the scene.
  bool shadows = true;
};

/// The organs on the graphics card. Render thread only.
class OrganRenderer {
 public:
  /// Compiles the program and uploads meshes, textures and, if `levels`, the meshes' levels. Throws
  /// MachineError if the driver refuses the shader. A texture for a mesh without texture
  /// coordinates is a bug.
  explicit OrganRenderer(const std::vector<OrganVisual>& organs, const ToolShade& shade = {},
                         bool levels = true);

  /// Moves the organs to the snapshot's shapes. Chooses the organs that `scope` may see and their
  /// levels. A shape is uploaded only if its version changed since the last call. Fewer organs or
  /// another number of vertices than at construction are a bug. Allocates nothing.
  void Move(const SceneSnapshot& snapshot, const Laparoscope& scope);

  /// Draws only depth.
  void DrawDepth() const;
  /// The same of one organ.
  void DrawDepthOf(std::size_t organ) const;

  /// Draws the organs. `occlusion` (of the same frame) may be null.
  void Draw(const Occlusion* occlusion) const;

  /// Returns the organ's mesh as the last Draw() drew it.
  MeshRenderer& mesh(std::size_t organ) { return organs_[organ].mesh; }
  const MeshRenderer& mesh(std::size_t organ) const { return organs_[organ].mesh; }

 private:
  struct Organ {
    MeshRenderer mesh;
    Texture texture;
    Eigen::Vector3f colour;  // linear, multiplies the texture's
    float metres_per_uv;
    std::unique_ptr<LatticeDeformation> deformation = {};  // null: the snapshot's vertices
    std::vector<MeshLevel> levels = {};                    // the first is the whole mesh
    std::optional<std::uint64_t> version = {};             // OrganSnapshot::version of the shape
    Vector3d low_W = Vector3d::Zero(), high_W = Vector3d::Zero();  // bounds of the shape, m
    bool may_be_seen = true;
    std::vector<double> errors = {};  // error of each level in the shape, m; < 0: unknown

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
