#pragma once

#include <Eigen/Core>
#include <vector>

#include "engine/snapshots.h"
#include "engine/surface_mesh.h"
#include "render/laparoscope.h"
#include "render/mesh_view.h"
#include "render/shaders.h"

namespace hpdm {

/// Colour as on a screen: sRGB, each component 0..1.
using Colour = Eigen::Vector3f;

/// An organ to draw. The mesh must outlive the view.
struct OrganView {
  const SurfaceMesh* rest = nullptr;  ///< Posed rest surface in the world, m: the vertices that
                                      ///< SceneSnapshot::organs[i].vertices moves.
  Colour colour = Colour(0.47f, 0.19f, 0.145f);  ///< Liver.
};

/// An instrument to draw, rigid in its tool frame T (origin at the centre of the tip sphere, z
/// along the shaft towards the trocar). The mesh must outlive the view.
struct InstrumentView {
  const SurfaceMesh* mesh = nullptr;            ///< In T, m; null: a capsule of the radii below.
  double tip_radius = 0.0025;                   ///< m.
  double shaft_radius = 0.0025;                 ///< m.
  Colour colour = Colour(0.80f, 0.81f, 0.83f);  ///< Steel.
};

/// Everything that is in the picture, on the graphics card. Draws into whatever framebuffer is
/// bound, so the same view serves pictures and a window. Render thread only, from construction to
/// destruction.
class SceneView {
 public:
  /// Compiles the programs and uploads the meshes. Throws MachineError when the driver refuses a
  /// shader.
  SceneView(const std::vector<OrganView>& organs, const std::vector<InstrumentView>& instruments);

  /// Draws the snapshot as the scope sees it, into a viewport of the scope's picture size. Organs
  /// and tools beyond those given at construction are not drawn; fewer are a bug, as is a vertex
  /// count that differs. Allocates nothing.
  void Draw(const SceneSnapshot& snapshot, const Laparoscope& scope);

 private:
  struct OrganMesh {
    MeshView mesh;
    Eigen::Vector3f colour;  // linear
  };
  struct InstrumentMesh {
    MeshView mesh;
    Eigen::Vector3f colour;  // linear
    float tip_radius;
    float shaft_radius;
  };
  /// A program that draws meshes, with the places of its two uniforms.
  struct MeshProgram {
    explicit MeshProgram(const char* name, const std::vector<const char*>& fragment_parts);
    void SetMesh(const Eigen::Matrix4f& world_from_mesh, const Eigen::Vector3f& colour) const;
    ShaderProgram program;
    int world_from_mesh;
    int base_colour;
  };

  void UploadFrame(const SceneSnapshot& snapshot, const Laparoscope& scope);

  MeshProgram tissue_;
  MeshProgram metal_;
  ShaderProgram cavity_;
  ShaderProgram surround_;
  GlObject frame_buffer_{GlKind::kBuffer};
  GlObject no_inputs_{GlKind::kVertexArray};
  std::vector<OrganMesh> organs_;
  std::vector<InstrumentMesh> instruments_;
};

}  // namespace hpdm
