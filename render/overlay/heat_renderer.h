#pragma once

#include <array>

#include "engine/snapshots.h"
#include "render/gl/gl_object.h"
#include "render/gl/shaders.h"
#include "render/tissue/mesh_renderer.h"

namespace hpdm {

/// A contact's force as a spot of colour that fades by the kernel cos(pi d / 2R), with d the
/// distance to the contact point.
struct ForceSpot {
  Vector3d p_W = Vector3d::Zero();  ///< Contact point, m.
  double radius = 0;                ///< R, m.
  double force = 0;                 ///< N.
};

/// Draws values on organs as colours (colour_map.h) over a finished picture, in a separate pass: a
/// picture without them costs nothing. Needs the frame's uniform block bound and the picture's
/// depth buffer, which it keeps. Render thread only.
class HeatRenderer {
 public:
  /// Throws MachineError if the driver refuses a shader.
  HeatRenderer();

  /// Draws spots of force on a drawn organ. The whole spot has the force's colour, so that it can
  /// be read beside the tip. Where spots overlap, the colour is the mean weighted by their kernels.
  /// `full_scale` (N) has the map's last colour.
  void DrawForce(const MeshRenderer& mesh, const std::array<ForceSpot, kMaxInstruments>& spots,
                 int spot_count, double full_scale);

  /// Draws the values of MeshRenderer::SetHeat on the whole organ; 1 has the map's last colour.
  void DrawVertexHeat(const MeshRenderer& mesh);

  /// Draws an upright bar of the map's colours in the middle of the picture's right edge, with a
  /// white frame and a tick at each quarter. `place` 0 is the outermost.
  void DrawBar(int place);

 private:
  void Begin() const;
  void End() const;

  ShaderProgram force_;
  ShaderProgram vertex_heat_;
  ShaderProgram bar_;
  int spot_count_, spots_, forces_, bar_place_;
  GlObject no_inputs_{GlKind::kVertexArray};
};

}  // namespace hpdm
