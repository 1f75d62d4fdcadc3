#pragma once

#include <vector>

#include "engine/snapshots.h"
#include "engine/surface_mesh.h"
#include "render/colour.h"
#include "render/frame_uniforms.h"
#include "render/mesh_view.h"
#include "render/shaders.h"

namespace hpdm {

/// An instrument to draw, rigid in its tool frame T (origin at the centre of the tip sphere, z
/// along the shaft towards the trocar). The mesh must outlive the view.
struct InstrumentView {
  const SurfaceMesh* mesh = nullptr;            ///< In T, m; null: a capsule of the radii below.
  double tip_radius = 0.0025;                   ///< m.
  double shaft_radius = 0.0025;                 ///< m.
  Colour colour = Colour(0.80f, 0.81f, 0.83f);  ///< Steel.
};

/// The instruments on the graphics card. Render thread only.
class InstrumentPainter {
 public:
  /// Compiles the program and uploads the meshes: at most kMaxInstruments, more are a bug. Throws
  /// MachineError when the driver refuses the shader.
  explicit InstrumentPainter(const std::vector<InstrumentView>& instruments);

  /// Puts the instruments that the snapshot has into the frame, for what lies in their shade.
  void AddTo(const SceneSnapshot& snapshot, FrameUniforms* frame) const;

  /// Draws the instruments that the snapshot has (none before the first tick). Allocates nothing.
  void Draw(const SceneSnapshot& snapshot) const;

 private:
  struct Instrument {
    MeshView mesh;
    Eigen::Vector3f colour;  // linear
    double tip_radius;
    double shaft_radius;
  };

  int DrawnCount(const SceneSnapshot& snapshot) const;

  ShaderProgram program_;
  int world_from_mesh_;
  int base_colour_;
  std::vector<Instrument> instruments_;
};

}  // namespace hpdm
