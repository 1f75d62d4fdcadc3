#pragma once

#include <array>

#include "engine/snapshots.h"
#include "render/gl/gl_object.h"
#include "render/gl/shaders.h"
#include "render/tissue/mesh_renderer.h"

namespace hpdm {

/// A contact's force as a spot of colour that fades by the kernel cos(pi d / 2R) of the distance d
/// to the contact point.
struct ForceSpot {
  Vector3d p_W = Vector3d::Zero();  ///< m.
  double radius = 0;                ///< R, m.
  double force = 0;                 ///< N.
};

/// Values on organs as colours of colour_map.h, drawn over a finished picture in a pass of their
/// own: a picture without them costs nothing. Needs the frame's uniform block bound, and the
/// picture's depths, which stay. Render thread only.
class HeatRenderer {
 public:
  /// Throws MachineError when the driver refuses a shader.
  HeatRenderer();

  /// Spots of force on an organ that has been drawn: the force's colour all over the spot, so that
  /// it can be read beside the tip; nothing beyond the radius; between two spots the mean by their
  /// kernels. `full_scale` (N) has the map's last colour.
  void DrawForce(const MeshRenderer& mesh, const std::array<ForceSpot, kMaxInstruments>& spots,
                 int spot_count, double full_scale);

  /// The values of MeshRenderer::SetHeat on all of the organ; 1 has the map's last colour.
  void DrawVertexHeat(const MeshRenderer& mesh);

  /// A bar of the map's colours with a white frame and a tick at each quarter, upright in the
  /// middle of the picture's right edge; `place` 0 is the outermost.
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
