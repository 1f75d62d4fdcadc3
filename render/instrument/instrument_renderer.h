#pragma once

#include <limits>
#include <vector>

#include "engine/mesh/surface_mesh.h"
#include "engine/snapshots.h"
#include "engine/step/tool_geometry.h"
#include "render/camera/frame_uniforms.h"
#include "render/gl/shaders.h"
#include "render/image/colour.h"
#include "render/tissue/mesh_renderer.h"

namespace hpdm {

/// A part of an instrument. The mesh must outlive the visual.
struct InstrumentPart {
  const SurfaceMesh* mesh = nullptr;  ///< In the tool frame T, jaws closed, m.
  double pivot = 0;                   ///< m: a jaw turns about the line x = 0, z = pivot.
  double opening = 0;  ///< rad, angle of an open jaw: positive opens towards +x; 0: rigid.
};

/// Returns the part's rigid pose in the tool frame for jaws at `jaw` (0 closed .. 1 open).
Isometry3d PoseInTool(const InstrumentPart& part, double jaw);

/// An instrument to draw in its tool frame T: origin at the centre of the tip sphere, z along the
/// shaft towards the trocar, y along the jaws' axis.
struct InstrumentVisual {
  std::vector<InstrumentPart> parts;  ///< Empty: a capsule of the radii below.
  ToolGeometry geometry;
  Colour colour = Colour(0.80f, 0.81f, 0.83f);  ///< Steel.
  /// m: the z in T where the shaft's insulation (plastic) begins.
  double insulated_from = std::numeric_limits<double>::infinity();
  Colour insulation = Colour(0.12f, 0.12f, 0.13f);
  /// Other instruments of this hand: ToolPose::instrument_index 1, 2, ... Theirs stay empty.
  std::vector<InstrumentVisual> exchanges = {};
};

/// The instruments on the graphics card. Render thread only.
class InstrumentRenderer {
 public:
  /// Compiles the program and uploads the meshes. More than kMaxInstruments are a bug. Throws
  /// MachineError if the driver refuses the shader.
  explicit InstrumentRenderer(const std::vector<InstrumentVisual>& instruments);

  /// Writes the snapshot's instruments into the frame's uniforms, for their shade on tissue.
  void AddTo(const SceneSnapshot& snapshot, FrameUniforms* frame) const;

  /// Draws the snapshot's instruments (none before the first tick) with the held instrument and jaw
  /// angle of each. Allocates nothing.
  void Draw(const SceneSnapshot& snapshot) const;

 private:
  struct Part {
    MeshRenderer mesh;
    InstrumentPart placed;
  };
  struct Instrument {
    std::vector<Part> parts;
    Eigen::Vector3f colour;      // linear
    Eigen::Vector3f insulation;  // linear
    double insulated_from;
    ToolGeometry geometry;
  };

  static Instrument Upload(const InstrumentVisual& visual);
  int DrawnCount(const SceneSnapshot& snapshot) const;
  Isometry3d PoseOf(const SceneSnapshot& snapshot, int tool) const;
  const Instrument& Held(int tool, const ToolPose& pose) const;

  ShaderProgram program_;
  int world_from_mesh_;
  int base_colour_;
  int insulation_;
  int insulated_from_;
  std::vector<std::vector<Instrument>> instruments_;  // [tool][ToolPose::instrument_index]
};

}  // namespace hpdm
