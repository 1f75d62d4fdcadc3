#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine/snapshots.h"
#include "render/camera/circle_mask.h"
#include "render/camera/frame_uniforms.h"
#include "render/camera/laparoscope.h"
#include "render/instrument/instrument_renderer.h"
#include "render/overlay/overlay_renderer.h"
#include "render/tissue/cavity_renderer.h"
#include "render/tissue/occlusion.h"
#include "render/tissue/organ_renderer.h"

namespace hpdm {

/// What may be left out of the picture on a slow machine.
struct SceneRendererOptions {
  bool occlusion = true;  ///< Shade in crevices and under instruments.
  bool levels = true;     ///< Fewer triangles for organs that are small (mesh_levels.h).
};

/// Everything that is in the picture, on the graphics card. Draws into whatever framebuffer is
/// bound, so the same view serves pictures and a window. Render thread only, from construction to
/// destruction.
class SceneRenderer {
 public:
  /// Compiles the programs and uploads meshes and textures. `background` (may be null) is the
  /// picture on the cavity's wall; it need not outlive the call. Throws MachineError when the
  /// driver refuses a shader.
  SceneRenderer(const std::vector<OrganVisual>& organs,
                const std::vector<InstrumentVisual>& instruments, const Image* background = nullptr,
                const SceneRendererOptions& options = {});

  /// Draws the snapshot as the scope sees it, into a viewport of the scope's picture size. Organs
  /// and tools beyond those given at construction are not drawn; fewer are a bug, as is a vertex
  /// count that differs. `overlays`: Overlay (view_settings.h), or-ed. Allocates nothing without
  /// overlays.
  void Draw(const SceneSnapshot& snapshot, const Laparoscope& scope, std::uint32_t overlays = 0);

  /// Draws the scales of the overlays' colours beside the picture, once it is resolved.
  void DrawScales(std::uint32_t overlays) { overlays_.DrawScales(overlays); }

 private:
  FrameBlock frame_;
  OrganRenderer organs_;
  InstrumentRenderer instruments_;
  CavityRenderer cavity_;
  std::optional<Occlusion> occlusion_;
  CircleMask mask_;
  OverlayRenderer overlays_;
};

}  // namespace hpdm
